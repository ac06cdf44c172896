// How far something is that is waited for, and the way to stop it.

import { t } from "../i18n/common.js";
import { h, html } from "../../vendor/ui.js";
import { Progress } from "./progress.js";

/** @param {{ watched: import("../api/watched.js").Watched, label: string }} props nothing while it does not run */
export function Underway({ watched: { running, progress, stop }, label }) {
  if (!running) return null;
  return html`<div class="underway">
    ${h(Progress, { label, progress })}
    <button type="button" class="button small" onClick=${stop}>${t.stop}</button>
  </div>`;
}
