// Indistinguishable coefficients: the server's sentence, translated into German by its data.

import german from "../i18n/de/dependencies.js";
import { fmt } from "../i18n/i18n.js";
import { t } from "../i18n/flank.js";
import { termSign } from "../lib/terms.js";
import { shownLanguage } from "../settings.js";
import { h, html } from "../../vendor/ui.js";

/** @typedef {import("../api/client.js").Schema<"NearDependency">} NearDependency */

/** @param {{ of: NearDependency }} props */
export function Dependency({ of }) {
  if (shownLanguage.value !== "de") return html`<span lang="en" translate="no">${termSign(of.sentence)}</span>`;
  const digits = (/** @type {number | undefined} */ value, /** @type {number} */ count) =>
    value === undefined || value === null ? undefined : fmt.value.input(Number(value.toPrecision(count)));
  const figures = {
    cosine: digits(of.cosine, 6),
    rSquared: digits(of.r_squared, 6),
    index: digits(of.condition_index, 4),
  };
  return html`<span translate="no">${german(of.terms.map(termSign), figures, of.cause)}</span>`;
}

/** Number of terms that are named; others are counted. */
const FEW = 2;

/**
 * Indistinguishable terms of a coefficient: by name if there are few, else by the numbers of the
 * sentences below.
 * @param {{ term: string | null | undefined, dependent: readonly NearDependency[] }} props
 */
export function Inseparable({ term, dependent }) {
  const numbers = dependent.flatMap(({ terms }, i) => (terms.includes(term ?? "") ? [i + 1] : []));
  if (numbers.length === 0) return null;
  const others = new Set(numbers.flatMap((number) => dependent[number - 1]?.terms ?? []));
  others.delete(term ?? "");
  const said =
    others.size <= FEW ? t.inseparable([...others].map(termSign).join(", ")) : t.inseparableBy(numbers.join(", "));
  return html`<span class="inseparable">${said}</span>`;
}

/** The same in sentences, below the coefficients. @param {{ dependent: readonly NearDependency[] }} props */
export function Dependencies({ dependent }) {
  if (dependent.length === 0) return null;
  return html`<section class="dependencies">
    <h3>${t.indistinguishable}</h3>
    <ol>${dependent.map((of, i) => html`<li key=${i}>${h(Dependency, { of })}</li>`)}</ol>
  </section>`;
}
