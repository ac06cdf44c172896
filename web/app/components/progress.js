// The progress of a long request.

import { t } from "../i18n/common.js";
import { fmt } from "../i18n/i18n.js";
import { html } from "../../vendor/ui.js";

/** @typedef {{ done: number, seconds: number | undefined } | undefined} Done not known before the server has reported it */

/** @param {{ label: string, progress: Done }} props */
export function Progress({ label, progress }) {
  const left = progress?.seconds;
  return html`<div class="progress">
    <progress aria-label=${label} value=${progress?.done} max="1"></progress>
    ${
      progress &&
      html`<span class="quiet"><span translate="no">${fmt.value.fixed(100 * progress.done, 0)}\u202f%</span>
        ${left !== undefined && t.secondsLeft(fmt.value.count(Math.ceil(left)))}</span>`
    }
  </div>`;
}
