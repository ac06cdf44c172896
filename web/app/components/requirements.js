// The requirements of a job.

import { Chart } from "../charts/chart.js";
import { Band, Line } from "../charts/marks.js";
import { fmt } from "../i18n/i18n.js";
import { t } from "../i18n/requirements.js";
import { ABSENT, capital } from "../lib/format.js";
import { ALL_FIGURES, heightAt, limitsOf, SIDES, SURFACE_FIGURES } from "../lib/requirements.js";
import { h, html } from "../../vendor/ui.js";
import { GearSymbol } from "./symbol.js";
import { table } from "./table.js";

/** @typedef {import("../lib/requirements.js").Requirements} Requirements */
/** @typedef {import("../lib/requirements.js").KBand} KBand */
/** @typedef {(typeof ALL_FIGURES)[number]} Figure */

/** @param {{ requirements: Requirements | undefined, name: string }} props `name`: of the job */
export function RequirementsPanel({ requirements, name }) {
  const of = requirements?.tolerance_limits?.class;
  const rows = ALL_FIGURES.filter((figure) => SIDES.some((side) => limitsOf(requirements, side, figure.name)));
  const sides = SIDES.filter((side) => rows.some((figure) => limitsOf(requirements, side, figure.name)));
  const bands = requirements?.k_bands ?? [];
  const ofPitch = requirements?.pitch_limits?.class;
  const { design } = requirements ?? {};
  const none = !design && of === undefined && ofPitch === undefined && rows.length === 0 && bands.length === 0;
  return html`<section class="panel" aria-labelledby="requirements">
    <h2 id="requirements">${t.title}</h2>
    ${none ? html`<p class="quiet">${t.none}</p>` : html`<p class="hint">${t.hint}</p>`}
    ${of !== undefined && html`<p><b>${t.classOf(of)}</b></p>`}
    ${ofPitch !== undefined && html`<p><b>${t.pitchClassOf(ofPitch)}</b></p>`}
    ${design && html`<p>${designText(design)}</p>`}
    ${
      rows.length > 0 &&
      table({
        caption: t.limits,
        hideCaption: true,
        rows,
        rowKey: (figure) => figure.name,
        csvName: `${name} ${t.limits}`,
        stacked: true,
        columns: [
          {
            key: "figure",
            header: t.figure,
            rowHeader: true,
            cell: (figure) => html`${h(GearSymbol, { name: figure.symbol })} ${t[figure.name]}`,
            csv: (figure) => figure.symbol.replace("_", " "),
          },
          ...sides.map((side) => limitColumn(requirements, side)),
        ],
      })
    }
    ${bands.length > 0 && html`<div class="k-bands">${bands.map((band, i) => h(BandChart, { key: i, band, number: i + 1, name }))}</div>`}
  </section>`;
}

/** A design as one line of text. @param {NonNullable<Requirements["design"]>} design */
function designText(design) {
  const of = (/** @type {import("../api/client.js").Schema<"FlankFigures">} */ figures) =>
    SURFACE_FIGURES.flatMap(({ name, symbol }) => {
      const value = figures[`${name}_um`];
      if (typeof value !== "number") return [];
      return [
        html`${h(GearSymbol, { name: symbol })} <span translate="no">${minus(fmt.value.input(value))}\u202fµm</span> `,
      ];
    });
  const count = design.modifications?.length ?? 0;
  return html`<b>${t.design}:</b> ${of(design)}
    ${design.left && html`${t.leftFlank} ${of(design.left)}`} ${design.right && html`${t.rightFlank} ${of(design.right)}`}
    ${count > 0 && t.modifications(count)}`;
}

/** @param {Requirements | undefined} requirements @param {"both" | "left" | "right"} side @returns {import("./table.js").Column<Figure>} */
function limitColumn(requirements, side) {
  return {
    key: side,
    header: t[side],
    unit: "µm",
    numeric: true,
    cell: (figure) => {
      const limits = limitsOf(requirements, side, figure.name);
      return limits ? html`<span translate="no">${limits.map(fmt.value.input).map(minus).join(" … ")}</span>` : ABSENT;
    },
    csv: (figure) => limitsOf(requirements, side, figure.name),
  };
}

/** @param {string} text */
const minus = (text) => text.replace("-", "\u2212");

/** @param {{ band: KBand, number: number, name: string }} props */
function BandChart({ band, number, name }) {
  const { kind, flank, upper, lower } = band;
  const axis = kind === "helix" ? "width" : (band.profile_axis ?? "roll_length");
  const unit = axis === "roll_angle" ? "°" : "mm";
  const places = [...upper, ...lower].map(([at = 0]) => at);
  const heights = [...upper, ...lower].map(([, value = 0]) => value);
  const [low, high] = [Math.min(...places), Math.max(...places)];
  const write = (/** @type {number} */ value) => `${minus(fmt.value.input(value))}\u202f${unit}`;
  const line = (/** @type {readonly number[][]} */ points) => points.map(([x = 0, y]) => ({ x, y }));
  const between = [...new Set(places)].sort((a, b) => a - b);
  /** @type {{ edge: "upper" | "lower", at: number, value: number }[]} */
  const rows = [
    ...upper.map(([at = 0, value = 0]) => ({ edge: /** @type {const} */ ("upper"), at, value })),
    ...lower.map(([at = 0, value = 0]) => ({ edge: /** @type {const} */ ("lower"), at, value })),
  ];
  return h(Chart, {
    name: t.bandOf(
      number,
      t[kind],
      flank === "left" ? t.leftFlank : flank === "right" ? t.rightFlank : t.bothFlanks,
      band.against === "design",
    ),
    summary: t.bandSummary(write(low), write(high)),
    height: 220,
    x: { label: capital(t[axis]), unit, domain: [low, high] },
    y: { label: t.deviation, unit: "µm", domain: [Math.min(0, ...heights), Math.max(0, ...heights)], nice: true },
    data: {
      rows,
      rowKey: ({ edge, at }) => `${edge} ${at}`,
      csvName: `${name} ${t.band(number)}`,
      columns: [
        {
          key: "edge",
          header: t.bands,
          rowHeader: true,
          cell: ({ edge }) => t[/** @type {"upper" | "lower"} */ (edge)],
          csv: ({ edge }) => t[/** @type {"upper" | "lower"} */ (edge)],
        },
        {
          key: "at",
          header: t.place,
          unit,
          numeric: true,
          cell: ({ at }) => html`<span translate="no">${minus(fmt.value.input(at))}</span>`,
          csv: ({ at }) => at,
        },
        {
          key: "value",
          header: t.deviation,
          unit: "µm",
          numeric: true,
          cell: ({ value }) => html`<span translate="no">${minus(fmt.value.input(value))}</span>`,
          csv: ({ value }) => value,
        },
      ],
    },
    children: (plot) => html`
      ${h(Band, { plot, series: "green", points: between.map((x) => ({ x, low: heightAt(lower, x), high: heightAt(upper, x) })) })}
      ${h(Line, { plot, series: "green", points: line(upper) })} ${h(Line, { plot, series: "green", points: line(lower) })}`,
  });
}
