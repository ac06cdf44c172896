// The coefficients along k, each relative to its least-squares estimate.

import { Chart } from "../charts/chart.js";
import { Line, Rule } from "../charts/marks.js";
import de from "../i18n/de/lambda.js";
import en from "../i18n/en/lambda.js";
import { fmt, texts } from "../i18n/i18n.js";
import { SERIES } from "../lib/colour.js";
import { h, html } from "../../vendor/ui.js";

/** @typedef {import("../api/client.js").Schema<"FitResult">} FitResult */
/** @typedef {import("../api/client.js").Schema<"RidgeTracePoint">} Point */

const t = texts({ en, de });

/** @param {{ points: readonly Point[], result: FitResult, at: number | undefined }} props */
export function RidgeTrace({ points, result, at }) {
  const along = points.filter(({ k }) => k > 0);
  const [first, last] = [along[0]?.k, along.at(-1)?.k];
  if (first === undefined || last === undefined) return null;
  const terms = result.coefficients;
  const part = (/** @type {Point} */ point, /** @type {number} */ i) => {
    const whole = terms[i]?.least_squares;
    return whole ? (point.coefficients[i] ?? 0) / whole : null;
  };
  const values = along.flatMap((point) => terms.map((_, i) => part(point, i) ?? 0));
  const label = (/** @type {number} */ i) => terms[i]?.term ?? "";
  return html`<section class="panel">${h(Chart, {
    name: t.ridgeTrace,
    level: 2,
    summary: t.ridgeSummary,
    x: { label: t.symbol("k"), scale: "log", domain: [first, last] },
    y: { label: t.ofLeastSquares, domain: [Math.min(0, ...values), Math.max(1, ...values)], nice: true },
    data: {
      columns: [
        {
          key: "k",
          header: t.symbol("k"),
          numeric: true,
          rowHeader: true,
          cell: ({ k }) => fmt.value.three(k),
          csv: ({ k }) => k,
        },
        ...terms.map(({ term }, i) => ({
          key: term,
          header: t.symbol(term),
          numeric: true,
          cell: (/** @type {Point} */ { coefficients }) => fmt.value.three(coefficients[i]),
          csv: (/** @type {Point} */ { coefficients }) => coefficients[i],
        })),
      ],
      rows: points,
      rowKey: ({ k }) => k,
      csvName: "ridge-trace",
    },
    children: (plot) => html`
      ${terms.map((_, i) => h(Line, { key: i, plot, points: along.map((point) => ({ x: point.k, y: part(point, i) })), series: SERIES[i % SERIES.length] ?? "blue", dash: i >= SERIES.length ? "4 3" : undefined }))}
      ${at !== undefined && at >= first && h(Rule, { plot, x: at, label: t.symbol("k") })}`,
  })}
  <ul class="lambda-legend" translate="no">${terms.map((_, i) => html`<li key=${i}><svg width="24" height="8" class="chart" aria-hidden="true"><path class=${`mark-line series-${SERIES[i % SERIES.length]}`} d="M0 4H24" stroke-dasharray=${i >= SERIES.length ? "4 3" : undefined} /></svg><code>${label(i)}</code></li>`)}</ul>
  </section>`;
}
