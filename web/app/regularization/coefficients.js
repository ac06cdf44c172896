// Coefficients before and after regularisation, and the filter factor of each direction.

import { Chart } from "../charts/chart.js";
import { Dots, Rule } from "../charts/marks.js";
import { estimateColumn, numberColumn, termColumn } from "../components/columns.js";
import { table } from "../components/table.js";
import { StripLegend } from "../charts/strip.js";
import { Dependencies, Inseparable } from "../components/dependency.js";
import { inUnit, stripColumn, unitOf } from "../flank/figures.js";
import de from "../i18n/de/lambda.js";
import en from "../i18n/en/lambda.js";
import { fmt, texts } from "../i18n/i18n.js";
import { estimateOf } from "../lib/strip.js";
import { reducedBy } from "../lib/spectrum.js";
import { termSign } from "../lib/terms.js";
import { h, html } from "../../vendor/ui.js";

/** @typedef {import("../api/client.js").Schema<"FitResult">} FitResult */
/** @typedef {FitResult["coefficients"][number]} Coefficient */

const t = texts({ en, de });

/**
 * @param {{ before: FitResult, after: FitResult, axes: import("../flank/figures.js").Axes | null | undefined, afterName: string, names: string }} props
 *   `before`: of the chosen fit; `names`: of the file
 */
export function Coefficients({ before, after, axes, afterName, names }) {
  const unit = (/** @type {Coefficient} */ one) => unitOf(one, axes);
  const same = before === after;
  const dependent = after.collinearity.near_dependencies ?? [];
  const chosen = new Map(before.coefficients.map((one) => [one.term, one]));
  /** @type {import("../components/table.js").Column<Coefficient>[]} */
  const columns = [
    {
      ...termColumn(t.term),
      cell: ({ term }) =>
        html`<span class="term" translate="no">${termSign(term)}</span> ${h(Inseparable, { term, dependent })}`,
    },
    {
      ...estimateColumn(
        "ls",
        t.leastSquares,
        (/** @type {Coefficient} */ one) => ({ value: one.least_squares, std_error: one.least_squares_std_error }),
        unit,
      ),
      // next to a refit only its mark fits
      minor: !same,
    },
    ...(same
      ? []
      : [estimateColumn("chosen", t.thisFit, (/** @type {Coefficient} */ { term }) => chosen.get(term), unit)]),
    estimateColumn("value", same ? t.thisFit : afterName, (one) => one, unit),
    {
      ...numberColumn("bound", t.biasBound, (/** @type {Coefficient} */ one) => one.bias_bound),
      cell: (one) => html`<span translate="no">${inUnit(fmt.value.three(one.bias_bound), one, axes)}</span>`,
    },
    stripColumn(axes),
  ];
  return html`<section class="panel">
    <h2>${t.coefficients}</h2>
    <p class="quiet">${t.coefficientsText}</p>
    ${table({
      caption: t.coefficients,
      hideCaption: true,
      columns,
      rows: after.coefficients,
      rowKey: ({ term }) => term,
      csvName: names,
      stacked: true,
      note: h(StripLegend, { estimates: after.coefficients.map(estimateOf) }),
    })}
    ${h(Dependencies, { dependent })}
  </section>`;
}

/** @param {{ result: FitResult, symbol: string }} props */
export function FilterFactors({ result, symbol }) {
  const factors = result.regularization.filter_factors;
  const eigenvalues = result.spectrum.eigenvalues;
  const points = factors.flatMap((y, i) => {
    const x = eigenvalues[i];
    return x !== undefined && x > 0 ? [{ x, y, i }] : [];
  });
  // with a prior or constraints they belong to other directions than the eigenvalues
  if (points.length === 0 || result.prior || result.constraints) return null;
  const [low, high] = [points[0]?.x ?? 1, points.at(-1)?.x ?? 10];
  const at = result.regularization.lambda_star;
  const reduced = reducedBy(factors);
  return html`<section class="panel">${h(Chart, {
    name: t.filterFactors,
    level: 2,
    summary: t.filterSummary(reduced, factors.length),
    x: { label: t.eigenvalue, scale: "log", domain: [Math.min(low, at ?? low) / 2, high * 2] },
    y: { label: t.filterFactor, domain: [0, Math.max(1.05, ...factors)] },
    height: 260,
    probes: points.map(({ x, y, i }) => ({ x, y, text: `${i + 1}: ${fmt.value.three(x)} → ${fmt.value.fixed(y, 3)}` })),
    data: {
      columns: [
        {
          key: "i",
          header: t.direction,
          numeric: true,
          rowHeader: true,
          cell: ({ i }) => i + 1,
          csv: ({ i }) => i + 1,
        },
        { key: "x", header: t.eigenvalue, numeric: true, cell: ({ x }) => fmt.value.three(x), csv: ({ x }) => x },
        { key: "y", header: t.filterFactor, numeric: true, cell: ({ y }) => fmt.value.fixed(y, 3), csv: ({ y }) => y },
      ],
      rows: points,
      rowKey: ({ i }) => i,
      csvName: "filter-factors",
    },
    children: (plot) =>
      html`${at !== undefined && at > 0 && h(Rule, { plot, x: at, label: t.symbol(symbol) })}${h(Dots, { plot, points })}`,
  })}</section>`;
}
