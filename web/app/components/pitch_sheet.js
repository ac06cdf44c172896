// Pitches and run-out as on pitch sheets: bars of single pitches, the curve of index deviations,
// run-out readings.

import { Chart } from "../charts/chart.js";
import { Bars, Dots, Line, Rule } from "../charts/marks.js";
import { t } from "../i18n/pitch.js";
import { fmt } from "../i18n/i18n.js";
import { dashOf } from "../lib/colour.js";
import { ABSENT } from "../lib/format.js";
import { h, html } from "../../vendor/ui.js";
import { Facts, WithError } from "./figure.js";
import { PitchTable } from "./pitch_table.js";
import { WarningList } from "./warnings.js";

/** @typedef {import("../api/client.js").Schema<"PitchEvaluation">} PitchEvaluation */
/** @typedef {import("../api/client.js").Schema<"FlankPitch">} FlankPitch */
/** @typedef {import("../api/client.js").Schema<"GearRunout">} GearRunout */
/** @typedef {import("../api/client.js").Schema<"GearTolerances">} GearTolerances */

/**
 * @param {{ pitch: PitchEvaluation, tolerances?: GearTolerances | undefined, csvName?: string | undefined, of?: string | undefined }} props
 *   `csvName`: offers tables as files of this name; on paper, without one, charts are lower and only drawn, and warnings
 *   stand elsewhere; `of`: says whose pitches they are, where there are several
 */
export function PitchSheet({ pitch, tolerances, csvName, of }) {
  const flanks = /** @type {const} */ (["left", "right"]).flatMap((flank) => pitch[flank] ?? []);
  const warnings = csvName === undefined ? [] : pitch.warnings;
  return html`
    ${flanks.map((one) => h(Pitches, { key: one.flank, of: one, all: flanks, csvName }))}
    ${pitch.runout && h(Runout, { of: pitch.runout, csvName })}
    ${h(PitchTable, { pitch, tolerances, csvName, of })}
    ${warnings.length > 0 && h(WarningList, { warnings })}`;
}

/** Values by tooth, from 1. @param {readonly (number | null)[]} values */
const byTooth = (values) => values.map((value, i) => ({ tooth: i + 1, value }));

/** @typedef {{ tooth: number, value: number | null }} Reading */

/** @param {string} csvName @param {string} header @param {readonly Reading[]} rows */
function asTable(csvName, header, rows) {
  return {
    rows,
    csvName,
    rowKey: (/** @type {Reading} */ { tooth }) => tooth,
    columns: /** @type {import("./table.js").Column<Reading>[]} */ ([
      {
        key: "tooth",
        header: t.tooth,
        rowHeader: true,
        cell: ({ tooth }) => html`<span translate="no">${fmt.value.count(tooth)}</span>`,
        csv: ({ tooth }) => tooth,
      },
      {
        key: "value",
        header,
        unit: "µm",
        numeric: true,
        cell: ({ value }) => html`<span translate="no">${fmt.value.fixed(value, 2)}</span>`,
        csv: ({ value }) => value,
      },
    ]),
  };
}

/** The parts of a chart that only the screen has. @param {string | undefined} csvName @param {string} name @param {string} header @param {readonly Reading[]} rows */
const toRead = (csvName, name, header, rows) =>
  csvName === undefined ? {} : { probes: probesOf(rows), data: asTable(`${csvName} ${name}`, header, rows) };

/** Returns the height of a chart: on paper all charts of an iteration fit on one page. @param {string | undefined} csvName @param {number} height */
const tall = (csvName, height) => (csvName === undefined ? 120 : height);

/** @param {readonly (number | null)[]} values */
const defined = (values) => values.filter((value) => value !== null);

/** @param {readonly (number | null)[]} values @returns {[number, number]} */
function domainOf(values) {
  const all = [0, ...defined(values)];
  return [Math.min(...all), Math.max(...all)];
}

/** The axis of deviations. @param {string | undefined} csvName @param {string} label @param {readonly (number | null)[]} values */
const upwards = (csvName, label, values) => ({
  label,
  unit: "µm",
  domain: domainOf(values),
  nice: true,
  ...(csvName === undefined ? { ticks: 4 } : {}),
});

/** @param {readonly Reading[]} rows */
const probesOf = (rows) =>
  rows.map(({ tooth, value }) => ({
    x: tooth,
    y: value ?? Number.NaN,
    text: t.reading(fmt.value.count(tooth), value === null ? ABSENT : fmt.value.fixed(value, 2)),
  }));

/** Single pitches and their limits. @param {FlankPitch} flank */
const singlesOf = ({ single_pitch_deviation_um: singles, single_pitch_limits_um: limits }) => [
  ...singles,
  ...(limits ?? []),
];

/**
 * The charts of a flank.
 * @param {{ of: FlankPitch, all: readonly FlankPitch[], csvName: string | undefined }} props `all`: the flanks that are drawn on one scale
 */
function Pitches({ of, all, csvName }) {
  const { flank, single_pitch_deviation_um: singles, index_deviation_um: index } = of;
  const whose = t[flank];
  const teeth = /** @type {const} */ ([0.5, singles.length + 0.5]);
  const x = { label: t.tooth, domain: teeth };
  const [bars, curve] = [byTooth(singles), byTooth(index)];
  const worst = of.single_pitch;
  const limits = of.single_pitch_limits_um ?? [];
  return html`<section class="pitch-flank" aria-label=${whose}>
    ${h(Chart, {
      name: t.singleOf(whose),
      summary: [
        t.singleSummary(fmt.value.um(worst?.value_um), worst ? fmt.value.count(worst.tooth) : ABSENT),
        ...(limits.length > 0 ? [t.limitsDrawn] : []),
      ].join(" "),
      height: tall(csvName, 200),
      x,
      y: upwards(csvName, t.singleShort, all.flatMap(singlesOf)),
      ...toRead(csvName, t.singleOf(whose), t.singleShort, bars),
      children: (plot) => html`
        ${h(Bars, { plot, bins: bars.flatMap(({ tooth, value }) => (value === null ? [] : [{ from: tooth - 0.4, to: tooth + 0.4, count: value }])) })}
        ${worst && h(Bars, { plot, series: "vermilion", bins: [{ from: worst.tooth - 0.4, to: worst.tooth + 0.4, count: worst.value_um }] })}
        ${h(Rule, { plot, y: 0, kind: "zero" })}
        ${limits.map((y) => h(Rule, { key: y, plot, y, kind: "limit" }))}`,
    })}
    ${h(Chart, {
      name: t.cumulativeOf(whose),
      summary: t.cumulativeSummary(fmt.value.um(of.cumulative_pitch_um)),
      height: tall(csvName, 240),
      x,
      // a low chart has no space for more
      y: upwards(
        csvName,
        csvName === undefined ? t.deviation : t.index,
        all.flatMap((one) => one.index_deviation_um),
      ),
      ...toRead(csvName, t.cumulativeOf(whose), t.index, curve),
      children: (plot) => html`
        ${h(Rule, { plot, y: 0, kind: "zero" })}
        ${endsOf(index).map((y) => h(Rule, { key: y, plot, y }))}
        ${h(Line, { plot, dash: dashOf(flank), points: curve.map(({ tooth, value }) => ({ x: tooth, y: value })) })}
        ${h(Dots, { plot, small: true, points: curve.map(({ tooth, value }) => ({ x: tooth, y: value })) })}`,
    })}
  </section>`;
}

/** Least and greatest, between which the total deviation lies. @param {readonly (number | null)[]} values */
function endsOf(values) {
  const all = defined(values);
  return all.length > 1 ? [Math.min(...all), Math.max(...all)] : [];
}

/** @param {{ of: GearRunout, csvName: string | undefined }} props */
function Runout({ of, csvName }) {
  const { readings_um: readings, eccentricity, derived } = of;
  const rows = byTooth(readings);
  const middle = mean(defined(readings));
  const wave =
    eccentricity &&
    Array.from({ length: 145 }, (_, i) => {
      const angle = (2 * Math.PI * i) / 144;
      const at = 1 + (readings.length * i) / 144;
      return { x: at, y: middle + eccentricity.amount_um * Math.cos(angle - (eccentricity.angle_deg * Math.PI) / 180) };
    });
  return html`<section class="pitch-flank" aria-label=${t.runout}>
    ${h(Chart, {
      name: derived ? t.runoutDerived : t.runoutRead,
      summary: t.runoutSummary(fmt.value.um(of.runout_um)),
      height: tall(csvName, 240),
      x: { label: t.space, domain: [0.5, readings.length + 0.5] },
      y: upwards(csvName, t.reading_, readings),
      ...toRead(csvName, t.runout, t.reading_, rows),
      children: (plot) => html`
        ${h(Rule, { plot, y: 0, kind: "zero" })}
        ${endsOf(readings).map((y) => h(Rule, { key: y, plot, y }))}
        ${wave && h(Line, { plot, series: "vermilion", dash: "9 3 1 3", thin: true, points: wave.filter(({ x }) => x <= readings.length) })}
        ${h(Line, { plot, points: rows.map(({ tooth, value }) => ({ x: tooth, y: value })) })}
        ${h(Dots, { plot, small: true, points: rows.map(({ tooth, value }) => ({ x: tooth, y: value })) })}`,
    })}
    ${
      eccentricity &&
      h(Facts, {
        items: [
          {
            name: t.eccentricity,
            value: h(WithError, { value: eccentricity.amount_um, error: eccentricity.std_error_um, unit: "µm" }),
          },
          { name: t.angle, value: html`<span translate="no">${fmt.value.fixed(eccentricity.angle_deg, 1)}°</span>` },
        ],
      })
    }
  </section>`;
}

/** @param {readonly number[]} values */
const mean = (values) => values.reduce((sum, one) => sum + one, 0) / Math.max(1, values.length);
