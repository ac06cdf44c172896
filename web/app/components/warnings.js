// Warnings of the server: in German by their codes, with the server's own sentence and its numbers
// below.

import german from "../i18n/de/warnings.js";
import { counted, plain } from "../lib/warnings.js";
import { shownLanguage } from "../settings.js";
import { html } from "../../vendor/ui.js";

/** @param {{ warnings: readonly import("../lib/warnings.js").Warning[] }} props */
export function WarningList({ warnings }) {
  return html`<ul class="warnings">
    ${counted(warnings).map(({ key, warning: { code, message }, times }) => {
      const sentence = shownLanguage.value === "de" ? german[code] : undefined;
      return html`<li key=${key}>
        ${sentence && html`<span>${sentence}</span>`}
        <span class=${sentence ? "said" : ""} lang="en" translate="no">${plain(message)}</span>${" "}
        <code translate="no">${code}</code>${times > 1 && html` <span class="quiet" translate="no">${times}×</span>`}
      </li>`;
    })}
  </ul>`;
}
