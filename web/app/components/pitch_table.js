// The figures of pitches and run-out, against their limits and their tolerances.

import { t } from "../i18n/pitch.js";
import { fmt } from "../i18n/i18n.js";
import { t as requirementText } from "../i18n/requirements.js";
import { ABSENT } from "../lib/format.js";
import { h, html } from "../../vendor/ui.js";
import { limitText } from "./flank_figures.js";
import { GearSymbol } from "./symbol.js";
import { table } from "./table.js";
import { Conforms, verdictText, Within } from "./within.js";

/** @typedef {import("../api/client.js").Schema<"PitchEvaluation">} PitchEvaluation */
/** @typedef {import("../api/client.js").Schema<"FlankPitch">} FlankPitch */
/** @typedef {import("../api/client.js").Schema<"GearRunout">} GearRunout */
/** @typedef {import("../api/client.js").Schema<"GearTolerances">} GearTolerances */
/** @typedef {import("../api/client.js").Schema<"Conformity">} Conformity */
/**
 * @typedef {object} Row
 * @property {string} key
 * @property {"f_p" | "F_p" | "F_pk" | "F_pSk" | "R_p" | "f_u" | "F_r"} symbol
 * @property {string} name
 * @property {string} flank
 * @property {number | undefined} value
 * @property {number | undefined} tooth
 * @property {number | undefined} tolerance
 * @property {number | undefined} class
 * @property {boolean} above11
 * @property {readonly number[] | undefined} limits the limits it was compared with
 * @property {boolean | undefined} within
 * @property {Conformity | undefined} conformity
 */

/**
 * @param {{ pitch: PitchEvaluation, tolerances: GearTolerances | undefined, csvName: string | undefined, of: string | undefined }} props
 *   `of`: says whose it is, where there are several
 */
export function PitchTable({ pitch, tolerances, csvName, of: whose }) {
  const values = tolerances?.rounded;
  const { left, right, runout } = pitch;
  const rows = [
    ...(left ? flankRows(left, values) : []),
    ...(right ? flankRows(right, values) : []),
    ...(runout ? [runoutRow(runout, values)] : []),
  ];
  const missing = [left, right, runout].reduce((sum, one) => sum + (one?.missing ?? 0), 0);
  const data = (/** @type {string} */ text) => html`<span translate="no">${text}</span>`;
  return html`${table({
    caption: whose ? `${t.title}, ${whose}` : t.title,
    hideCaption: true,
    csvName,
    stacked: true,
    rows,
    rowKey: ({ key }) => key,
    note: [
      ...(pitch.counting ? [pitch.counting === "counterclockwise" ? t.counterclockwise : t.clockwise] : []),
      ...(rows.some(({ within }) => within !== undefined) ? [t.withinHint] : []),
    ].join(" "),
    columns: /** @type {import("./table.js").Column<Row>[]} */ ([
      {
        key: "figure",
        header: t.figure,
        rowHeader: true,
        cell: ({ symbol, name }) => html`${h(GearSymbol, { name: symbol })} <span class="figure-name">${name}</span>`,
        csv: ({ symbol }) => symbol.replace("_", " "),
      },
      { key: "flank", header: t.flank, cell: ({ flank }) => flank || ABSENT, csv: ({ flank }) => flank },
      {
        key: "value",
        header: t.value,
        unit: "µm",
        numeric: true,
        cell: ({ value, within }) => html`${data(fmt.value.um(value))} ${h(Within, { within })}`,
        csv: ({ value }) => value,
      },
      {
        key: "tooth",
        header: t.atTooth,
        numeric: true,
        cell: ({ tooth }) => data(fmt.value.count(tooth)),
        csv: ({ tooth }) => tooth,
      },
      {
        key: "tolerance",
        header: tolerances ? t.tolerance(tolerances.class) : t.toleranceNone,
        unit: "µm",
        numeric: true,
        cell: values ? ({ tolerance }) => data(fmt.value.um(tolerance)) : undefined,
        csv: values ? ({ tolerance }) => tolerance : undefined,
      },
      {
        key: "class",
        header: t.class,
        numeric: true,
        cell: ({ class: of, above11 }) => (above11 ? t.above11 : data(fmt.value.count(of))),
        csv: ({ class: of, above11 }) => (above11 ? ">11" : of),
      },
      {
        key: "limits",
        header: requirementText.limitsOf,
        unit: "µm",
        numeric: true,
        cell: rows.some(({ limits }) => limits) ? ({ limits }) => data(limitText(limits)) : undefined,
        csv: ({ limits }) => limits,
      },
      { key: "within", header: requirementText.within, csv: ({ within }) => within },
      {
        key: "conformity",
        header: requirementText.conformity,
        cell: rows.some(({ conformity }) => conformity) ? ({ conformity }) => h(Conforms, { conformity }) : undefined,
        csv: ({ conformity }) => verdictText(conformity),
      },
    ]),
  })}${missing > 0 && html`<p class="note">${t.missing(missing)}</p>`}`;
}

/** @param {FlankPitch} of @param {import("../api/client.js").Schema<"ToleranceValues">} [tolerances] @returns {Row[]} */
export function flankRows(of, tolerances) {
  const flank = of.flank === "left" ? t.leftShort : t.rightShort;
  const above11 = of.class.coarser_than_11 ?? [];
  const row = (/** @type {Partial<Row> & Pick<Row, "key" | "symbol" | "name">} */ own) => ({
    flank,
    value: undefined,
    tooth: undefined,
    tolerance: undefined,
    class: undefined,
    above11: false,
    limits: undefined,
    within: undefined,
    conformity: undefined,
    ...own,
    key: `${own.key} ${of.flank}`,
  });
  return [
    row({
      key: "single",
      symbol: "f_p",
      name: t.single,
      value: of.single_pitch?.value_um,
      tooth: of.single_pitch?.tooth,
      tolerance: tolerances?.single_pitch_um,
      class: of.class.single_pitch,
      above11: above11.includes("single_pitch"),
      limits: of.single_pitch_limits_um,
      within: of.single_pitch_within,
      conformity: of.single_pitch_conformity,
    }),
    row({
      key: "cumulative",
      symbol: "F_p",
      name: t.cumulative,
      value: of.cumulative_pitch_um,
      tolerance: tolerances?.cumulative_pitch_um,
      class: of.class.cumulative_pitch,
      above11: above11.includes("cumulative_pitch"),
      limits: of.cumulative_pitch_limits_um,
      within: of.cumulative_pitch_within,
      conformity: of.cumulative_pitch_conformity,
    }),
    row({
      key: "sector 2013",
      symbol: "F_pk",
      name: t.sector(fmt.value.count(of.k)),
      value: of.sector_pitch_2013?.value_um,
      tooth: of.sector_pitch_2013?.tooth,
    }),
    row({
      key: "sector sum 2013",
      symbol: "F_pSk",
      name: t.sectorSum(fmt.value.count(of.k)),
      value: of.sector_sum_2013?.value_um,
      tooth: of.sector_sum_2013?.tooth,
    }),
    row({
      key: "sector 1995",
      symbol: "F_pk",
      name: t.sector1995(fmt.value.count(of.k)),
      value: of.sector_pitch_1995?.value_um,
      tooth: of.sector_pitch_1995?.tooth,
    }),
    row({ key: "range", symbol: "R_p", name: t.range, value: of.single_pitch_range_um }),
    row({
      key: "adjacent",
      symbol: "f_u",
      name: t.adjacent,
      value: of.adjacent_pitch_difference?.value_um,
      tooth: of.adjacent_pitch_difference?.tooth,
    }),
  ];
}

/** @param {GearRunout} of @param {import("../api/client.js").Schema<"ToleranceValues">} [tolerances] @returns {Row} */
export function runoutRow(of, tolerances) {
  return {
    key: "runout",
    symbol: "F_r",
    name: of.derived ? t.runoutFromPitches : t.runout,
    flank: "",
    value: of.runout_um,
    tooth: undefined,
    tolerance: tolerances?.runout_um,
    class: of.class,
    above11: of.coarser_than_11,
    limits: of.limits_um,
    within: of.within,
    conformity: of.conformity,
  };
}
