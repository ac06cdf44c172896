// The estimates of a stream over the number of its nodes.

import { Chart } from "../charts/chart.js";
import { Band, Dots, Line } from "../charts/marks.js";
import de from "../i18n/de/stream.js";
import en from "../i18n/en/stream.js";
import { fmt, texts } from "../i18n/i18n.js";
import { unitOf } from "../flank/figures.js";
import { termSign } from "../lib/terms.js";
import { h, html } from "../../vendor/ui.js";

/** @typedef {import("../api/stream.js").Estimate} Estimate */
/** @typedef {import("../api/client.js").Schema<"Axes">} Axes */

const t = texts({ en, de });

/** @param {readonly Estimate[]} history @returns {[number, number]} */
const nodesOf = (history) => [history[0]?.nodes ?? 0, history.at(-1)?.nodes ?? 1];

/** @param {string} text */
const data = (text) => html`<span translate="no">${text}</span>`;

/** @template {{ nodes: number }} Row @returns {import("./table.js").Column<Row>} */
function nodesColumn() {
  return {
    key: "nodes",
    header: t.nodes,
    numeric: true,
    rowHeader: true,
    cell: ({ nodes }) => data(fmt.value.count(nodes)),
    csv: ({ nodes }) => nodes,
  };
}

/** A coefficient with its standard error. @param {{ history: readonly Estimate[], term: string, axes: Axes | null | undefined }} props */
export function CoefficientChart({ history, term, axes }) {
  const points = history.flatMap(({ nodes, result }) => {
    const one = result.coefficients.find((coefficient) => coefficient.term === term);
    if (!one) return [];
    const error = one.std_error ?? 0;
    return [{ nodes, one, x: nodes, y: one.value, low: one.value - error, high: one.value + error }];
  });
  const last = points.at(-1);
  if (!last) return null;
  const unit = unitOf(last.one, axes);
  const write = (/** @type {typeof last.one} */ one) => fmt.value.withError(one.value, one.std_error, unit);
  return h(Chart, {
    name: t.coefficient(termSign(term)),
    summary: t.after(write(last.one), fmt.value.count(last.nodes)),
    height: 280,
    x: { label: t.nodes, domain: nodesOf(history) },
    y: {
      label: t.axis,
      unit,
      domain: [Math.min(...points.map(({ low }) => low)), Math.max(...points.map(({ high }) => high))],
      nice: true,
    },
    probes: points.map(({ x, y, one }) => ({ x, y, text: `${fmt.value.count(x)}: ${write(one)}` })),
    data: {
      columns: /** @type {import("./table.js").Column<typeof last>[]} */ ([
        nodesColumn(),
        {
          key: "value",
          header: t.value,
          numeric: true,
          cell: ({ one }) => data(write(one)),
          csv: ({ one }) => one.value,
        },
        { key: "error", header: t.error, unit, csv: ({ one }) => one.std_error },
      ]),
      rows: points,
      rowKey: ({ nodes }) => nodes,
      csvName: `stream-${term}`,
    },
    children: (plot) =>
      html`${h(Band, { plot, points })}${h(Line, { plot, points })}${h(Dots, { plot, points, small: true })}`,
  });
}

/** A figure above 0 over the number of nodes. @param {{ history: readonly Estimate[], kind: "condition" | "lambda" }} props */
export function FigureChart({ history, kind }) {
  const read = (/** @type {Estimate["result"]} */ result) =>
    kind === "lambda"
      ? { y: result.regularization.lambda_star, after: undefined }
      : { y: result.spectrum.condition, after: result.spectrum.regularized?.condition };
  const points = history.flatMap(({ nodes, result }) => {
    const { y, after } = read(result);
    return typeof y === "number" && y > 0 ? [{ nodes, x: nodes, y, after }] : [];
  });
  const last = points.at(-1);
  if (!last)
    return kind === "lambda"
      ? html`<div class="chart-figure"><div class="chart-head"><h3>${t.lambda}</h3></div><p class="quiet">${t.noLambda}</p></div>`
      : null;
  const format = kind === "lambda" ? fmt.value.three : fmt.value.condition;
  const write = ({ y, after } = last) => (after === undefined ? format(y) : `${format(y)} → ${format(after)}`);
  const values = points.flatMap(({ y, after }) => (after === undefined ? [y] : [y, after]));
  return h(Chart, {
    name: t[kind],
    summary: t.after(write(), fmt.value.count(last.nodes)),
    height: 240,
    x: { label: t.nodes, domain: nodesOf(history) },
    y: { label: t[kind], scale: "log", domain: [Math.min(...values) / 1.2, Math.max(...values) * 1.2] },
    probes: points.map((one) => ({ x: one.x, y: one.y, text: `${fmt.value.count(one.x)}: ${write(one)}` })),
    data: {
      columns: /** @type {import("./table.js").Column<typeof last>[]} */ ([
        nodesColumn(),
        { key: "y", header: t[kind], numeric: true, cell: ({ y }) => data(format(y)), csv: ({ y }) => y },
        ...(kind === "lambda"
          ? []
          : [
              {
                key: "after",
                header: t.regularised,
                numeric: true,
                cell: (/** @type {typeof last} */ { after }) => data(format(after)),
                csv: (/** @type {typeof last} */ { after }) => after,
              },
            ]),
      ]),
      rows: points,
      rowKey: ({ nodes }) => nodes,
      csvName: `stream-${kind}`,
    },
    children: (plot) =>
      html`${h(Line, { plot, points })}${h(Dots, { plot, points, small: true })}
      ${
        kind === "condition" &&
        h(Line, { plot, points: points.map(({ x, after }) => ({ x, y: after })), series: "vermilion", dash: "6 4" })
      }`,
  });
}
