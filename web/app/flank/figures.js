// The results of a fit next to its map: figures, coefficients with error and bias bound, warnings.

import { Facts, WithError } from "../components/figure.js";
import { table } from "../components/table.js";
import { t } from "../i18n/flank.js";
import { fmt } from "../i18n/i18n.js";
import { ABSENT } from "../lib/format.js";
import { termSign } from "../lib/terms.js";
import { estimateOf } from "../lib/strip.js";
import { heightUnit, unitSign } from "../lib/units.js";
import { Dependencies, Inseparable } from "../components/dependency.js";
import { Strip, StripLegend } from "../charts/strip.js";
import { WarningList } from "../components/warnings.js";
import { h, html } from "../../vendor/ui.js";

/** @typedef {import("../api/client.js").Schema<"FitResult">} FitResult */
/** @typedef {import("../api/client.js").Schema<"Axes">} Axes */
/** @typedef {import("../api/client.js").Schema<"Coefficient">} Coefficient */

/** @param {{ result: FitResult, axes: Axes | null | undefined }} props */
export function FitFigures({ result, axes }) {
  return html`<section class="panel" aria-labelledby="figures">
    <h2 id="figures">${t.figures}</h2>
    ${h(FitFacts, { result, axes })}
  </section>`;
}

/** @param {{ result: FitResult, axes: Axes | null | undefined, level?: number | undefined }} props `level`: of the intervals */
export function FitCoefficients({ result, axes, level }) {
  return html`<section class="panel figures-panel" aria-labelledby="coefficients">
    <h2 id="coefficients">${t.coefficients}</h2>
    ${h(CoefficientTable, { result, axes, level, hideCaption: true })}
  </section>`;
}

/** @param {{ result: FitResult, axes: Axes | null | undefined }} props */
export function FitFacts({ result, axes }) {
  const { residuals, regularization, spectrum } = result;
  const unit = heightUnit(axes);
  const data = (/** @type {string} */ text) => html`<span translate="no">${text}</span>`;
  const withUnit = (/** @type {string} */ text) => data(unit && text !== "–" ? `${text} ${unit}` : text);
  const items = [
    { name: t.rms, value: withUnit(fmt.value.three(residuals.rms)) },
    { name: t.maxAbs, value: withUnit(fmt.value.three(residuals.max_abs)) },
    { name: t.sigma, value: withUnit(fmt.value.three(residuals.sigma)) },
    { name: t.lambdaStar, value: data(fmt.value.three(regularization.lambda_star)) },
    {
      name: t.criterion,
      value: html`<code translate="no">${regularization.criterion ?? regularization.type}</code>`,
    },
    { name: t.condition, value: data(fmt.value.condition(spectrum.condition)) },
    { name: t.conditionAfter, value: data(fmt.value.condition(spectrum.regularized?.condition)) },
  ];
  return h(Facts, { items, columns: true });
}

/**
 * @param {{ result: FitResult, axes: Axes | null | undefined, level?: number | undefined, hideCaption?: boolean }} props `level`: of
 *   the intervals, which are shown if the fit has them
 */
export function CoefficientTable({ result, axes, level = 0.95, hideCaption = false }) {
  const dependent = result.collinearity.near_dependencies ?? [];
  /** @type {readonly import("../components/table.js").Column<Coefficient>[]} */
  const columns = [
    {
      key: "term",
      header: t.term,
      rowHeader: true,
      cell: (one) =>
        html`<span class="term" translate="no">${termSign(one.term)}</span> ${h(Inseparable, { term: one.term, dependent })}`,
      csv: (one) => one.term,
    },
    {
      key: "value",
      header: t.value,
      numeric: true,
      cell: (one) => h(WithError, { value: one.value, error: one.std_error, unit: unitOf(one, axes) }),
      csv: (one) => one.value,
    },
    {
      key: "bias",
      header: t.biasBound,
      numeric: true,
      cell: (one) => html`<span translate="no">${inUnit(fmt.value.significant(one.bias_bound, 2), one, axes)}</span>`,
      csv: (one) => one.bias_bound,
    },
    // drawn below the interval, if there is one: a column of its own does not fit next to the map
    ...(result.coefficients.some(({ interval }) => interval) ? intervalColumns(level, axes) : [stripColumn(axes)]),
  ];
  return html`${table({
    caption: t.coefficients,
    hideCaption,
    columns,
    rows: result.coefficients,
    rowKey: (one) => one.term ?? one.value,
    csvName: "coefficients",
    stacked: true,
    note: h(StripLegend, { estimates: result.coefficients.map(estimateOf) }),
  })}${h(Dependencies, { dependent })}`;
}

/** Coefficients as they are drawn, each on a scale of its own. @param {Axes | null | undefined} axes @returns {import("../components/table.js").Column<Coefficient>} */
export const stripColumn = (axes) => ({
  key: "strip",
  header: t.drawn,
  cell: (one) => stripOf(one, axes),
});

/** @param {Coefficient} one @param {Axes | null | undefined} axes */
const stripOf = (one, axes) => h(Strip, { estimates: [estimateOf(one)], unit: unitOf(one, axes) });

/** @param {number} level @param {Axes | null | undefined} axes @returns {import("../components/table.js").Column<Coefficient>[]} */
function intervalColumns(level, axes) {
  const name = t.interval(fmt.value.input(Number((100 * level).toPrecision(12))));
  return [
    {
      key: "interval",
      header: name,
      numeric: true,
      cell: (one) =>
        html`<span translate="no">${inUnit(fmt.value.interval(one.interval, one.least_squares_std_error), one, axes)}</span>
          <div>${stripOf(one, axes)}</div>`,
    },
    { key: "low", header: `${name}: ${t.low}`, csv: ({ interval }) => interval?.[0] },
    { key: "high", header: `${name}: ${t.high}`, csv: ({ interval }) => interval?.[1] },
  ];
}

/** A number in the unit of a coefficient. @param {string} text @param {Parameters<typeof unitOf>[0]} coefficient @param {Axes | null | undefined} axes */
export function inUnit(text, coefficient, axes) {
  const unit = unitOf(coefficient, axes);
  return unit && text !== ABSENT ? `${text}\u202f${unit}` : text;
}

/**
 * Returns the unit of a coefficient: µm/mm² of raw powers, that of the heights if the term is a
 * function of places on −1 … 1.
 * @param {{ powers?: readonly number[] | null, term?: string | null }} coefficient @param {Axes | null | undefined} axes
 */
export function unitOf({ powers, term }, axes) {
  if (term?.includes("(")) return heightUnit(axes);
  const [top, u, v] = [heightUnit(axes), unitSign(axes?.u?.unit), unitSign(axes?.v?.unit)];
  if (!top || !powers || !u || (powers.length > 1 && !v)) return undefined;
  const [p = 0, q = 0] = powers;
  const signs = ["", "", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"];
  const power = (/** @type {string} */ unit, /** @type {number} */ n) => unit + (signs[n] ?? `^${n}`);
  if (p + q === 0) return top;
  if (u === v) return `${top}/${power(u, p + q)}`;
  const below = [p > 0 && power(u, p), q > 0 && v && power(v, q)].filter(Boolean).join("·");
  return `${top}/${below.includes("·") ? `(${below})` : below}`;
}

/** A warning of every fit without a limit of its own: shown with the statistics, not with the warnings of this fit. */
const ALWAYS = "norm_limit_is_estimate";

/** Warnings, and the results that are valid in spite of them. @param {{ result: FitResult, half?: boolean }} props `half`: half as wide, including the warnings of every fit */
export function Warnings({ result, half = false }) {
  const known = result.estimable ?? [];
  const warnings = half ? result.warnings : result.warnings.filter(({ code }) => code !== ALWAYS);
  if (warnings.length === 0 && known.length === 0) return null;
  return html`<section class=${half ? "panel half" : "panel"} aria-labelledby="warnings">
    <h2 id="warnings">${t.toKnow}</h2>
    ${warnings.length > 0 && h(WarningList, { warnings })}
    ${
      known.length > 0 &&
      html`<details><summary>${t.estimable(known.length)}</summary>
        <ul class="warnings" lang="en" translate="no">${known.map(({ sentence }, i) => html`<li key=${i}>${sentence}</li>`)}</ul></details>`
    }
  </section>`;
}
