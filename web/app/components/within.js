// Whether a value lies within its limits.

import { t } from "../i18n/requirements.js";
import { html } from "../../vendor/ui.js";

/** By a sign and in words; nothing where it has none. @param {{ within: boolean | null | undefined }} props */
export function Within({ within }) {
  if (typeof within !== "boolean") return null;
  return html`<b class=${within ? "within" : "within not"}><span aria-hidden="true" translate="no">${within ? "✓" : "✗"}</span><span
    class="visually-hidden">${within ? t.within : t.outside}</span></b>`;
}

/** The signs of conformity decisions. */
export const SIGNS = /** @type {const} */ ({ conforms: "✓", does_not_conform: "✗", cannot_be_told: "?" });

/** A conformity decision by its sign, where there is no room for words. @param {{ decision: keyof typeof SIGNS | null | undefined }} props */
export function Decided({ decision }) {
  if (!decision) return null;
  return html`<b class=${decision === "does_not_conform" ? "within not" : "within"}><span aria-hidden="true" translate="no">${SIGNS[decision]}</span><span
    class="visually-hidden">${t[decision]}</span></b>`;
}
