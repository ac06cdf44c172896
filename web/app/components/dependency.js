// Coefficients that cannot be told apart: the server's sentence, in German by its data.

import german from "../i18n/de/dependencies.js";
import { fmt } from "../i18n/i18n.js";
import { termSign } from "../lib/terms.js";
import { shownLanguage } from "../settings.js";
import { html } from "../../vendor/ui.js";

/** @param {{ of: import("../api/client.js").Schema<"NearDependency"> }} props */
export function Dependency({ of }) {
  if (shownLanguage.value !== "de") return html`<span lang="en" translate="no">${termSign(of.sentence)}</span>`;
  const digits = (/** @type {number | undefined} */ value, /** @type {number} */ count) =>
    value === undefined || value === null ? undefined : fmt.value.input(Number(value.toPrecision(count)));
  const figures = {
    cosine: digits(of.cosine, 6),
    rSquared: digits(of.r_squared, 6),
    index: digits(of.condition_index, 4),
  };
  return html`<span translate="no">${german(of.terms.map(termSign), figures)}</span>`;
}
