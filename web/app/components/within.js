// Whether a value lies within its limits.

import { t } from "../i18n/requirements.js";
import { html } from "../../vendor/ui.js";

/** By a sign and in words; nothing where it has none. @param {{ within: boolean | null | undefined }} props */
export function Within({ within }) {
  if (typeof within !== "boolean") return null;
  return html`<b class=${within ? "within" : "within not"}><span aria-hidden="true" translate="no">${within ? "✓" : "✗"}</span><span
    class="visually-hidden">${within ? t.within : t.outside}</span></b>`;
}
