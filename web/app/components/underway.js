// The progress of a request that somebody waits for, and the way to stop it.

import { CancelledError } from "../api/watched.js";
import { t } from "../i18n/common.js";
import { h, html } from "../../vendor/ui.js";
import { Progress } from "./progress.js";

/** @param {{ watched: import("../api/watched.js").Watched, label: string }} props nothing while it does not run */
export function Underway({ watched: { running, progress, stop }, label }) {
  if (!running) return null;
  return html`<div class="underway">
    ${h(Progress, { label, progress })}
    <button type="button" class="button small" onClick=${stop}>${t.cancel}</button>
  </div>`;
}

/** Returns the message for a stopped request; undefined for other errors. @param {unknown} error */
export function stopNote(error) {
  return error instanceof CancelledError ? t.cancelled : undefined;
}
