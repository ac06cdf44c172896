// Nodes of a curve as a line: measured, with the fit, or the residuals.

import { Chart } from "../charts/chart.js";
import { Dots, Line, Rule } from "../charts/marks.js";
import { t } from "../i18n/flank.js";
import { fmt } from "../i18n/i18n.js";
import { heightUnit } from "../lib/units.js";
import { extent } from "../../vendor/d3.js";
import { h, html } from "../../vendor/ui.js";
import { axisOf } from "./axes.js";

/**
 * @param {{ nodes: import("../api/client.js").Schema<"CurveNodes">, layer: string, file: string,
 *   residuals: import("../api/client.js").Schema<"Residuals"> | undefined,
 *   axes: import("../api/client.js").Schema<"Axes"> | null | undefined }} props
 */
export function FlankCurve({ nodes, residuals, layer, axes, file }) {
  const place = (/** @type {number} */ k) => nodes.x[residuals?.node_indices?.[k] ?? k] ?? 0;
  const sorted = (/** @type {readonly { x: number, y: number }[]} */ points) => [...points].sort((a, b) => a.x - b.x);
  const values = layer === "residual" ? residuals?.values : layer === "fitted" ? residuals?.fitted : undefined;
  const measured = sorted(nodes.x.map((x, i) => ({ x, y: nodes.y[i] ?? Number.NaN })));
  const points = values ? sorted(values.map((y, k) => ({ x: place(k), y }))) : measured;
  const [x, unit] = [axisOf(axes?.x, "x"), heightUnit(axes)];
  const [across, up] = [domainOf(nodes.x), domainOf([...points.map(({ y }) => y), 0])];
  const placeOf = (/** @type {number} */ at) => fmt.value.onScale(at, across[1] - across[0], "mm");
  const heightOf = (/** @type {number} */ y) => fmt.value.onScale(y, Math.max(-up[0], up[1]), unit);
  const text = (/** @type {{ x: number, y: number }} */ one) =>
    `${placeOf(one.x)}${x.unit ? ` ${x.unit}` : ""}: ${heightOf(one.y)}${unit ? ` ${unit}` : ""}`;
  const [least, greatest] = [
    points.reduce((a, b) => (b.y < a.y ? b : a), points[0] ?? { x: 0, y: 0 }),
    points.reduce((a, b) => (b.y > a.y ? b : a), points[0] ?? { x: 0, y: 0 }),
  ];
  return h(Chart, {
    name: t.curve,
    summary: t.extremes(text(least), text(greatest)),
    x: { ...x, domain: across },
    y: { ...axisOf(axes?.y, "y"), domain: up, nice: true },
    probes: points.map((one) => ({ ...one, text: text(one) })),
    data: {
      columns: [
        {
          key: "x",
          header: x.label,
          unit: x.unit,
          numeric: true,
          cell: (one) => html`<span translate="no">${placeOf(one.x)}</span>`,
          csv: (one) => one.x,
        },
        {
          key: "y",
          header: t.deviation,
          unit,
          numeric: true,
          cell: (one) => html`<span translate="no">${heightOf(one.y)}</span>`,
          csv: (one) => one.y,
        },
      ],
      rows: points.slice(0, 2000),
      rowKey: (one) => one.x,
      csvName: file,
    },
    children: (plot) =>
      html`${h(Rule, { plot, y: 0, kind: "zero" })}${layer === "fitted" && h(Dots, { plot, points: measured, small: true, series: "ink" })}${h(Line, { plot, points })}`,
  });
}

/** @param {readonly number[]} values @returns {[number, number]} */
function domainOf(values) {
  const [low = 0, high = 1] = extent(values);
  return [low ?? 0, high ?? 1];
}
