// Short news, also announced to screen readers.

import { t } from "../i18n/common.js";
import { html, signal } from "../../vendor/ui.js";

/** @typedef {{ id: number, text: string, kind: "done" | "news" | "failed" }} Toast */

const STAYS = 8000;
let last = 0;
/** @type {import("../../vendor/ui.js").Signal<Toast[]>} */
const toasts = signal(/** @type {Toast[]} */ ([]));
/** @type {import("../../vendor/ui.js").Signal<string>} */
const spoken = signal("");

/** Shows a sentence; a failure stays until it is dismissed, anything else until the next one. @param {string} text @param {Toast["kind"]} [kind] */
export function notify(text, kind = "done") {
  last += 1;
  const id = last;
  const others = kind === "failed" ? toasts.value : toasts.value.filter((toast) => toast.kind === "failed");
  toasts.value = [...others, { id, text, kind }].slice(-4);
  if (kind !== "failed") setTimeout(() => dismiss(id), STAYS);
}

/** Announces a text to screen readers only. @param {string} text */
export function announce(text) {
  spoken.value = text;
}

/** @param {number} id */
function dismiss(id) {
  toasts.value = toasts.value.filter((toast) => toast.id !== id);
}

export function Toasts() {
  return html`<div class="toasts" role="status" aria-live="polite">
    ${toasts.value.map(
      ({ id, text, kind }) => html`<div key=${id} class=${`toast ${kind}`}>
        <span>${text}</span>
        <button type="button" class="icon-button" aria-label=${t.dismiss} onClick=${() => dismiss(id)}>
          <svg viewBox="0 0 16 16" width="16" height="16" aria-hidden="true"><path d="M3 3l10 10M13 3L3 13" /></svg>
        </button>
      </div>`,
    )}
    <span class="visually-hidden">${spoken.value}</span>
  </div>`;
}
