// Residuals: their distribution, and their places.

import { Chart } from "../charts/chart.js";
import { Bars, Dots, Line, Rule } from "../charts/marks.js";
import { Facts } from "../components/figure.js";
import { table } from "../components/table.js";
import { axisOf } from "../flank/axes.js";
import de from "../i18n/de/statistics.js";
import en from "../i18n/en/statistics.js";
import { fmt, texts } from "../i18n/i18n.js";
import { heightUnit } from "../lib/units.js";
import { h, html } from "../../vendor/ui.js";
import { histogram, MOST_POINTS, placeOfNode, quantiles, thinned } from "./distribution.js";

/** @typedef {import("../api/client.js").Schema<"FitResult">} FitResult */
/** @typedef {import("../api/client.js").Schema<"Nodes">} Nodes */
/** @typedef {import("../api/client.js").Schema<"Axes">} Axes */

const t = texts({ en, de });

/** @param {{ result: FitResult, nodes: Nodes | undefined, axes: Axes | null | undefined }} props */
export function Residuals({ result, nodes, axes }) {
  const { residuals, robust } = result;
  const values = residuals.values ?? [];
  const unit = heightUnit(axes);
  const index = (/** @type {number} */ i) => residuals.node_indices?.[i] ?? i;
  const data = (/** @type {string} */ text) => html`<span translate="no">${text}</span>`;
  const height = (/** @type {number | null | undefined} */ value) =>
    data(`${fmt.value.three(value)}${unit ? ` ${unit}` : ""}`);
  const places = nodes && values.length > 0 ? Object.keys(placeOfNode(nodes, 0)) : [];
  const axis = (/** @type {string} */ name) => {
    const known =
      /** @type {Record<string, import("../api/client.js").Schema<"Axis"> | null | undefined> | undefined} */ (
        /** @type {unknown} */ (axes)
      );
    const { label, unit: of } = axisOf(known?.[name], name);
    return { label: known?.[name] ? label : t.data(label), unit: of };
  };
  return html`<section class="panel wide">
      <h2>${t.residuals}</h2>
      ${h(Facts, {
        items: [
          { name: t.counted, value: data(fmt.value.count(residuals.count)) },
          { name: t.freedom, value: data(fmt.value.count(residuals.degrees_of_freedom)) },
          { name: t.sigma, value: height(residuals.sigma) },
          { name: t.rms, value: height(residuals.rms) },
          { name: t.maxAbs, value: height(residuals.max_abs) },
          { name: t.rSquared, value: data(fmt.value.fixed(residuals.r_squared, 4)) },
        ],
      })}
      ${values.length > MOST_POINTS && html`<p class="note">${t.thinned(MOST_POINTS, values.length)}</p>`}
      <div class="statistics-charts">
        ${values.length > 0 && h(Histogram, { values, unit })}
        ${values.length > 0 && h(QuantilePlot, { values, sigma: residuals.sigma ?? residuals.rms, unit })}
        ${
          nodes &&
          places.map((name) =>
            h(Against, {
              key: name,
              name: t.against(name),
              file: name,
              axis: axis(name),
              unit,
              points: values.map((y, i) => ({ x: placeOfNode(nodes, index(i))[name] ?? 0, y })),
            }),
          )
        }
        ${values.length > 0 && h(Against, { name: t.againstOrder, file: "order", axis: { label: t.order }, unit, points: values.map((y, i) => ({ x: index(i) + 1, y })) })}
      </div>
    </section>
    ${robust && h(Robust, { robust, index, nodes, residuals: values })}`;
}

/** @param {{ values: readonly number[], unit: string | undefined }} props */
function Histogram({ values, unit }) {
  const bins = histogram(values);
  const most = Math.max(...bins.map(({ count }) => count));
  return h(Chart, {
    name: t.histogram,
    summary: t.histogramSummary(bins.length, values.length),
    x: { label: t.residual, unit, domain: [bins[0]?.from ?? 0, bins.at(-1)?.to ?? 1] },
    y: { label: t.count, domain: [0, most * 1.05] },
    height: 260,
    probes: bins.map(({ from, to, count }) => ({
      x: (from + to) / 2,
      y: count,
      text: `${fmt.value.three(from)} … ${fmt.value.three(to)}: ${count}`,
    })),
    data: {
      columns: [
        {
          key: "from",
          header: t.from,
          unit,
          numeric: true,
          rowHeader: true,
          cell: ({ from }) => fmt.value.three(from),
          csv: ({ from }) => from,
        },
        { key: "to", header: t.to, unit, numeric: true, cell: ({ to }) => fmt.value.three(to), csv: ({ to }) => to },
        {
          key: "count",
          header: t.count,
          numeric: true,
          cell: ({ count }) => fmt.value.count(count),
          csv: ({ count }) => count,
        },
      ],
      rows: bins,
      rowKey: ({ from }) => from,
      csvName: "residuals-histogram",
    },
    children: (plot) => h(Bars, { plot, bins }),
  });
}

/** @param {{ values: readonly number[], sigma: number, unit: string | undefined }} props */
function QuantilePlot({ values, sigma, unit }) {
  const points = thinned(quantiles(values));
  const [first, last] = [points[0], points.at(-1)];
  if (!first || !last) return null;
  const reach = Math.max(Math.abs(first.y), Math.abs(last.y), sigma * last.x);
  return h(Chart, {
    name: t.qq,
    summary: t.qqSummary,
    x: { label: t.quantile, domain: [first.x, last.x], nice: true },
    y: { label: t.residual, unit, domain: [-reach, reach], nice: true },
    height: 260,
    probes: points.map(({ x, y }) => ({ x, y, text: `${fmt.value.fixed(x, 2)}: ${fmt.value.three(y)}` })),
    data: pairs(t.quantile, undefined, unit, points, "residuals-quantiles"),
    children: (plot) => html`
      ${h(Line, {
        plot,
        points: [
          { x: first.x, y: sigma * first.x },
          { x: last.x, y: sigma * last.x },
        ],
        series: "vermilion",
        thin: true,
      })}
      ${h(Dots, { plot, points, small: true })}`,
  });
}

/** @param {{ name: string, file: string, axis: { label: string, unit?: string | undefined }, unit: string | undefined, points: readonly { x: number, y: number }[] }} props */
function Against({ name, file, axis, unit, points }) {
  const shown = thinned(points);
  const reach = points.reduce((most, { y }) => Math.max(most, Math.abs(y)), 0) || 1;
  const low = points.reduce((least, { x }) => Math.min(least, x), Number.POSITIVE_INFINITY);
  const high = points.reduce((most, { x }) => Math.max(most, x), Number.NEGATIVE_INFINITY);
  return h(Chart, {
    name,
    summary: t.againstSummary(`${fmt.value.three(reach)}${unit ? ` ${unit}` : ""}`),
    x: { ...axis, domain: [low, high], nice: true },
    y: { label: t.residual, unit, domain: [-reach, reach], nice: true },
    height: 260,
    probes: shown.map(({ x, y }) => ({ x, y, text: `${fmt.value.three(x)}: ${fmt.value.three(y)}` })),
    data: pairs(axis.label, axis.unit, unit, shown, `residuals-${file}`),
    children: (plot) => html`${h(Rule, { plot, y: 0, kind: "zero" })}${h(Dots, { plot, points: shown, small: true })}`,
  });
}

/** @param {string} label @param {string | undefined} of @param {string | undefined} unit @param {readonly { x: number, y: number }[]} points @param {string} csvName */
function pairs(label, of, unit, points, csvName) {
  const rows = points.map((point, i) => ({ ...point, i }));
  return {
    columns: [
      {
        key: "x",
        header: label,
        unit: of,
        numeric: true,
        rowHeader: true,
        cell: (/** @type {(typeof rows)[number]} */ { x }) => fmt.value.three(x),
        csv: (/** @type {(typeof rows)[number]} */ { x }) => x,
      },
      {
        key: "y",
        header: t.residual,
        unit,
        numeric: true,
        cell: (/** @type {(typeof rows)[number]} */ { y }) => fmt.value.three(y),
        csv: (/** @type {(typeof rows)[number]} */ { y }) => y,
      },
    ],
    rows,
    rowKey: (/** @type {(typeof rows)[number]} */ { i }) => i,
    csvName,
  };
}

/** @param {readonly { x: number, y: number }[]} rows */
function weightTable(rows) {
  return {
    rows,
    rowKey: (/** @type {{ x: number }} */ { x }) => x,
    csvName: "weights",
    columns: /** @type {import("../components/table.js").Column<{ x: number, y: number }>[]} */ ([
      {
        key: "node",
        header: t.order,
        numeric: true,
        rowHeader: true,
        cell: ({ x }) => fmt.value.count(x),
        csv: ({ x }) => x,
      },
      {
        key: "weight",
        header: t.weight,
        numeric: true,
        cell: ({ y }) => html`<span translate="no">${fmt.value.fixed(y, 3)}</span>`,
        csv: ({ y }) => y,
      },
    ]),
  };
}

/** @param {{ robust: NonNullable<FitResult["robust"]>, index: (i: number) => number, nodes: Nodes | undefined, residuals: readonly number[] }} props */
function Robust({ robust, index, nodes, residuals }) {
  const weights = (robust.weights ?? []).map((y, i) => ({ x: index(i) + 1, y }));
  const order = new Map(residuals.map((value, i) => [index(i), value]));
  const rejected = (robust.rejected ?? [])
    .slice(0, MOST_POINTS)
    .map((node) => ({ node, residual: order.get(node), place: nodes ? placeOfNode(nodes, node) : {} }));
  return html`<section class="panel wide">
    <h2>${t.robust}</h2>
    <p>${robust.converged ? t.converged(robust.iterations) : t.notConverged(robust.iterations)} ${t.rejectedCount(robust.rejected_count)}</p>
    ${
      weights.length > 0 &&
      h(Chart, {
        name: t.weightsOfNodes,
        summary: t.weightsSummary(weights.filter(({ y }) => y < 0.5).length, weights.length),
        x: { label: t.order, domain: [1, weights.at(-1)?.x ?? 2], nice: true },
        y: { label: t.weight, domain: [0, 1.05] },
        height: 240,
        probes: thinned(weights).map(({ x, y }) => ({ x, y, text: `${x}: ${fmt.value.fixed(y, 3)}` })),
        data: weightTable(thinned(weights)),
        children: (plot) => h(Dots, { plot, points: thinned(weights), small: true }),
      })
    }
    ${
      rejected.length > 0 &&
      table({
        caption: t.rejected,
        columns: [
          {
            key: "node",
            header: t.order,
            numeric: true,
            rowHeader: true,
            cell: ({ node }) => fmt.value.count(node + 1),
            csv: ({ node }) => node + 1,
          },
          {
            key: "u",
            header: t.data("u"),
            numeric: true,
            cell: ({ place }) => fmt.value.mm(place["u"] ?? place["x"]),
            csv: ({ place }) => place["u"] ?? place["x"],
          },
          {
            key: "v",
            header: t.data("v"),
            numeric: true,
            cell: ({ place }) => fmt.value.mm(place["v"]),
            csv: ({ place }) => place["v"],
          },
          {
            key: "residual",
            header: t.residual,
            numeric: true,
            cell: ({ residual }) => fmt.value.three(residual),
            csv: ({ residual }) => residual,
          },
        ],
        rows: rejected,
        rowKey: ({ node }) => node,
        csvName: "rejected",
      })
    }
  </section>`;
}
