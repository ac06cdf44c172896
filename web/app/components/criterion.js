// A criterion for λ*: its label, and its name in the API.

import de from "../i18n/de/criteria.js";
import en from "../i18n/en/criteria.js";
import { texts } from "../i18n/i18n.js";
import { html } from "../../vendor/ui.js";

const t = texts({ en, de });

/** @param {string | null | undefined} name */
export function criterionLabel(name) {
  return name && name in en ? t[/** @type {keyof typeof en} */ (name)] : undefined;
}

/** @param {{ name: string | null | undefined }} props */
export function Criterion({ name }) {
  if (!name) return html`<span>${t.none}</span>`;
  const label = criterionLabel(name);
  return html`<span class="criterion">${label && html`<span>${label}</span> `}<code translate="no">${name}</code></span>`;
}
