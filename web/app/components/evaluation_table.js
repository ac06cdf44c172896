// The figures of traces: each tooth, means, tolerances.

import { t } from "../i18n/evaluation.js";
import { fmt } from "../i18n/i18n.js";
import { ABSENT } from "../lib/format.js";
import { h, html } from "../../vendor/ui.js";
import { WithError } from "./figure.js";
import { limitText } from "./flank_figures.js";
import { Conforms, Decided, verdictText, Within } from "./within.js";
import { GearSymbol } from "./symbol.js";
import { table } from "./table.js";

/** @typedef {import("../api/client.js").Schema<"GearEvaluation">} GearEvaluation */
/** @typedef {import("../api/client.js").Schema<"EvaluatedTrace">} EvaluatedTrace */
/** @typedef {import("../api/client.js").Schema<"GearTolerances">} GearTolerances */
/** @typedef {import("../api/client.js").Schema<"ToleranceLimits">} ToleranceLimits */
/**
 * @typedef {object} Row
 * @property {string} key
 * @property {string} name
 * @property {string} flank
 * @property {EvaluatedTrace} [trace]
 * @property {Partial<Record<FigureKey, number | null | undefined>>} values
 * @property {Partial<Record<FigureKey, readonly number[] | undefined>>} [limits] instead of values
 */
/** @typedef {"slope" | "form" | "total" | "crowning"} FigureKey */

/** Symbols of the figures. @param {"profile" | "helix"} kind */
export const symbolsOf = (kind) =>
  kind === "profile"
    ? { slope: "f_Hα", form: "f_fα", total: "F_α", crowning: "C_α" }
    : { slope: "f_Hβ", form: "f_fβ", total: "F_β", crowning: "C_β" };

/** @param {"left" | "right"} flank */
const flankName = (flank) => (flank === "left" ? t.leftShort : t.rightShort);

/**
 * @param {{ kind: "profile" | "helix", evaluation: GearEvaluation, tolerances: GearTolerances | undefined, csvName?: string | undefined, brief?: boolean, of?: string }} props
 *   `brief`: without intervals and words of signs; `of`: says whose it is, where there are several
 */
export function EvaluationTable({ kind, evaluation, tolerances, csvName, brief = false, of }) {
  const symbols = symbolsOf(kind);
  const { value } = fmt;
  const settings = evaluation.evaluation;
  const rows = rowsOf(kind, evaluation, tolerances);
  const um = "µm";
  /** @param {"form" | "total"} key @returns {import("./table.js").Column<Row>} */
  const plain = (key) => ({
    key,
    header: t.symbol(symbols[key].replace("_", " ")),
    head: h(GearSymbol, { name: symbols[key] }),
    unit: um,
    numeric: true,
    cell: ({ values, limits, trace }) =>
      limits
        ? data(limitText(limits[key]))
        : html`${data(value.um(values[key]))} ${h(Within, { within: trace?.[`${key}_within`] })}`,
    csv: ({ values, limits }) => limits?.[key] ?? values[key],
  });
  /** @param {"slope" | "crowning"} key @returns {import("./table.js").Column<Row>} */
  const estimated = (key) => ({
    key,
    header: t.symbol(symbols[key].replace("_", " ")),
    head: h(GearSymbol, { name: symbols[key] }),
    unit: um,
    numeric: true,
    cell: ({ values, limits, trace }) => {
      if (limits) return data(limitText(limits[key]));
      const error = trace?.[`${key}_std_error_um`];
      const figure = error ? h(WithError, { value: values[key], error }) : data(value.um(values[key]));
      const ends = brief ? undefined : trace?.[`${key}_interval_um`];
      return html`${figure} ${h(Within, { within: trace?.[`${key}_within`], conformity: trace?.[`${key}_conformity`] })}${
        ends && html`<span class="below" translate="no">${value.interval(ends, error)}</span>`
      }`;
    },
    csv: ({ values, limits }) => limits?.[key] ?? values[key],
  });
  /** @param {"slope" | "crowning"} key @returns {import("./table.js").Column<Row>} */
  const interval = (key) => ({
    key: `${key}-interval`,
    header: t.intervalOf(symbols[key].replace("_", " ")),
    unit: um,
    csv: ({ trace }) => trace?.[`${key}_interval_um`] ?? undefined,
  });
  /** @type {import("./table.js").Column<Row>[]} */
  const columns = [
    { key: "name", header: t.toothColumn, rowHeader: true, cell: ({ name }) => name, csv: ({ name }) => name },
    { key: "flank", header: t.flank, cell: ({ flank }) => flank, csv: ({ flank }) => flank },
    estimated("slope"),
    interval("slope"),
    {
      key: "sign",
      header: t.sign,
      minor: true,
      cell: ({ trace }) =>
        trace ? html`<span class="signed">${signOf(kind, trace.slope_um, settings.sign)}</span>` : "",
      csv: ({ trace }) => (trace ? signOf(kind, trace.slope_um, settings.sign) : ""),
    },
    plain("form"),
    plain("total"),
    estimated("crowning"),
    interval("crowning"),
    {
      key: "class",
      header: t.class,
      numeric: true,
      cell: ({ trace }) => (trace ? data(classOf(trace)) : ""),
      csv: ({ trace }) => (trace ? classOf(trace) : ""),
    },
    {
      key: "conformity",
      header: t.conformity,
      cell: ({ trace }) => {
        const found = conformities(trace);
        return found.length === 0
          ? ABSENT
          : found.map(
              ([key, conformity]) =>
                html`<span key=${key} class="conformity">${h(GearSymbol, { name: symbols[key] })} ${h(brief ? Decided : Conforms, { conformity })}</span>`,
            );
      },
    },
    ...ESTIMATED.map((key) => ({
      key: `${key}-conformity`,
      header: t.conformityOf(symbols[key].replace("_", " ")),
      csv: (/** @type {Row} */ { trace }) => verdictText(trace?.[`${key}_conformity`]),
    })),
    {
      key: "band",
      header: t.kBand,
      minor: true,
      cell: ({ trace }) =>
        trace?.k_bands?.length
          ? trace.k_bands.map(
              (one) =>
                html`<span key=${one.band} class="k-found">${h(Within, { within: one.within })} ${bandWords(one)}</span>`,
            )
          : ABSENT,
      csv: ({ trace }) => trace?.k_bands?.map(({ band, within }) => `${band}: ${within ?? ""}`).join("; "),
    },
  ];
  const listed = brief ? columns.filter(({ key }) => key !== "sign" && !key.endsWith("interval")) : columns;
  // columns without values are hidden, but kept in the file
  const shown = listed.map((column) => (isAnswered(column.key, rows) ? column : { ...column, cell: undefined }));
  const level = fmt.value.input(Number((100 * (settings.level ?? 0.95)).toPrecision(12)));
  const intervals = !brief && rows.some(({ trace }) => trace?.slope_interval_um || trace?.crowning_interval_um);
  return table({
    caption: of ? `${t[kind]}, ${of}` : t[kind],
    hideCaption: true,
    csvName,
    stacked: true,
    rows,
    rowKey: ({ key }) => key,
    rowClass: ({ trace }) => (trace ? "" : "summary"),
    columns: shown,
    note: intervals && t.intervalsBelow(level),
  });
}

/** Figures with errors. */
const ESTIMATED = /** @type {const} */ (["slope", "crowning"]);

/** @param {EvaluatedTrace | undefined} trace */
function conformities(trace) {
  return ESTIMATED.flatMap((key) => {
    const conformity = trace?.[`${key}_conformity`];
    return conformity ? [/** @type {const} */ ([key, conformity])] : [];
  });
}

/** Describes the position of a trace in a band. @param {import("../api/client.js").Schema<"KBandFinding">} found */
export function bandWords({ band, within, clearance_um: clearance }) {
  const number = band + 1;
  if (within === undefined) return t.bandUndecided(number);
  return within ? t.bandClearance(number, fmt.value.um(clearance)) : t.bandLack(number, fmt.value.um(-clearance));
}

/** Returns true if some trace has a value in a column. @param {string} key @param {readonly Row[]} rows */
function isAnswered(key, rows) {
  if (key === "conformity") return rows.some(({ trace }) => conformities(trace).length > 0);
  return key !== "band" || rows.some(({ trace }) => trace?.k_bands?.length);
}

/** @param {"profile" | "helix"} kind @param {GearEvaluation} evaluation @param {GearTolerances | undefined} tolerances @returns {Row[]} */
function rowsOf(kind, evaluation, tolerances) {
  const order = (/** @type {{ flank: string }} */ { flank }) => (flank === "left" ? 0 : 1);
  const traces = evaluation.traces.filter((trace) => trace.kind === kind).sort((a, b) => order(a) - order(b));
  const means = evaluation.means.filter((mean) => mean.kind === kind).sort((a, b) => order(a) - order(b));
  const flanks = /** @type {const} */ (["left", "right"]).filter((flank) =>
    traces.some((trace) => trace.flank === flank),
  );
  const rounded = evaluation.evaluation.tolerances === "unrounded" ? tolerances?.unrounded : tolerances?.rounded;
  return [
    ...traces.map((trace, i) => ({
      key: `trace ${i}`,
      name: t.tooth(trace.tooth),
      flank: flankName(trace.flank),
      trace,
      values: { slope: trace.slope_um, form: trace.form_um, total: trace.total_um, crowning: trace.crowning_um },
    })),
    ...means.flatMap((mean) =>
      /** @type {const} */ (["mean", "variation"]).map((what) => ({
        key: `${what} ${mean.flank}`,
        name: t[what],
        flank: flankName(mean.flank),
        values: {
          slope: mean.slope_um[what],
          form: mean.form_um[what],
          total: mean.total_um[what],
          crowning: mean.crowning_um[what],
        },
      })),
    ),
    ...flanks.flatMap((flank) => {
      const limits = limitsOf(kind, evaluation.evaluation.tolerance_limits, flank);
      const row = { key: `limits ${flank}`, name: t.limits, flank: flankName(flank), values: {}, limits };
      return Object.values(limits).some(Boolean) ? [row] : [];
    }),
    ...(tolerances && rounded
      ? [
          {
            key: "tolerance",
            name: t.tolerance(tolerances.class),
            flank: "",
            values: {
              slope: rounded[`${kind}_slope_um`],
              form: rounded[`${kind}_form_um`],
              total: rounded[`${kind}_total_um`],
            },
          },
        ]
      : []),
  ];
}

/** @param {"profile" | "helix"} kind @param {number | null | undefined} slope @param {string | null | undefined} sign */
function signOf(kind, slope, sign) {
  if (typeof slope !== "number") return ABSENT;
  if (slope === 0) return t.zero;
  if (sign === "as_given" || (kind === "helix" && sign === "vdi")) return t.asSigned;
  if (kind === "profile") return slope > 0 ? t.toTip : t.toRoot;
  return slope > 0 ? t.rightHand : t.leftHand;
}

/** The coarsest class of a trace. @param {EvaluatedTrace} trace */
function classOf({ class: of }) {
  if (!of) return ABSENT;
  if (of.coarser_than_11 && of.coarser_than_11.length > 0) return t.above11;
  const classes = [of.slope, of.form, of.total].filter((one) => typeof one === "number");
  return classes.length > 0 ? String(Math.max(...classes)) : ABSENT;
}

/** The required limits by figure, each flank's own before those of both. @param {"profile" | "helix"} kind @param {ToleranceLimits | undefined} limits @param {"left" | "right"} flank */
function limitsOf(kind, limits, flank) {
  const of = (/** @type {FigureKey} */ key) => limits?.[flank]?.[`${kind}_${key}_um`] ?? limits?.[`${kind}_${key}_um`];
  return { slope: of("slope"), form: of("form"), total: of("total"), crowning: of("crowning") };
}

/** @param {string} text */
const data = (text) => html`<span translate="no">${text}</span>`;
