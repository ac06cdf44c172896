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

/** A conformity outcome by its sign, where there is no room for words. @param {{ outcome: keyof typeof SIGNS | null | undefined }} props */
export function Decided({ outcome }) {
  if (!outcome) return null;
  return html`<b class=${outcome === "does_not_conform" ? "within not" : "within"}><span aria-hidden="true" translate="no">${SIGNS[outcome]}</span><span
    class="visually-hidden">${t[outcome]}</span></b>`;
}
