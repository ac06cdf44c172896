// The figures of a report's first page: only values that the interface returned for each iteration.
// Pure.

import { verdictOf } from "../components/within.js";
import { extremesOf } from "../flank/surface.js";

/** @typedef {import("./data.js").ReportData} ReportData */
/** @typedef {import("../api/client.js").Schema<"EstimatedFigure">} EstimatedFigure */
/** @typedef {import("../api/client.js").Schema<"EvaluatedTrace">} EvaluatedTrace */
/** @typedef {import("../api/client.js").Schema<"Conformity">} Conformity */
/** @typedef {"profile_slope" | "helix_slope" | "profile_crowning" | "helix_crowning" | "twist"} FlankFigureName */
/** @typedef {{ low: number, high: number }} Limits */
/**
 * @typedef {object} Cell
 * @property {number} value µm
 * @property {number | undefined} error
 * @property {readonly number[] | undefined} [interval]
 * @property {number | undefined} [bias] the most that it can be
 * @property {number | undefined} [class] the coarsest of its traces
 * @property {Conformity | undefined} [conformity]
 */
/**
 * @typedef {object} Row
 * @property {string} key
 * @property {string} symbol
 * @property {FlankFigureName | "trace_slope" | "trace_total"} name
 * @property {"left" | "right" | undefined} flank
 * @property {readonly (Cell | undefined)[]} cells one an iteration
 * @property {EstimatedFigure | undefined} change from the first to the last
 * @property {Limits | undefined} limits
 */

/** @type {readonly [FlankFigureName, string][]} */
const FLANK = [
  ["profile_slope", "f_Hα"],
  ["helix_slope", "f_Hβ"],
  ["profile_crowning", "C_α"],
  ["helix_crowning", "C_β"],
  ["twist", "S"],
];

/**
 * Returns the figures of the second-order surface: from the chosen fits, from the nodes as in
 * corrections, or from traces as in evaluations. All iterations have the same source: the one with
 * more figures and, if these are equal, the one whose figures are compared with limits.
 * @param {readonly ReportData[]} data @returns {{ rows: Row[], source: "fits" | "nodes" | "traces" }}
 */
export function flankRows(data) {
  const whole =
    data.length > 1 && data.at(-1)?.measuredCorrection?.id === data[0]?.correction?.id
      ? data.at(-1)?.measuredCorrection
      : undefined;
  /** @param {(one: ReportData, name: FlankFigureName) => Cell | undefined} cell @returns {Row[]} */
  const rows = (cell) =>
    FLANK.map(([name, symbol]) => ({
      key: name,
      symbol,
      name,
      flank: undefined,
      cells: data.map((one) => cell(one, name)),
      change:
        cell === ofTraces ? undefined : whole?.answer?.figure_changes?.[/** @type {const} */ (`${name}_um`)]?.change,
      limits: data
        .flatMap((one) => limitsOf([cell === ofFits ? fittedFigure(one, name) : tracedFigure(one, name)]))
        .at(-1),
    }));
  const [fits, nodes, traces] = /** @type {const} */ ([
    { rows: rows(ofFits), source: "fits" },
    { rows: rows(ofNodes), source: "nodes" },
    { rows: rows(ofTraces), source: "traces" },
  ]);
  // a change belongs to the figures that it is the difference of
  const all = whole?.answer ? [nodes, fits, traces] : [fits, nodes, traces];
  const score = (/** @type {{ rows: readonly Row[] }} */ { rows: own }) =>
    2 * covered(own) + (own.some(({ cells }) => cells.some((cell) => cell?.conformity)) ? 1 : 0);
  return all.reduce((best, one) => (score(one) > score(best) ? one : best));
}

/** @param {ReportData} data @param {FlankFigureName} name @returns {Cell | undefined} */
function ofFits(data, name) {
  const figure = fittedFigure(data, name);
  return figure && cellOf(figure);
}

/** @param {import("../api/client.js").Schema<"FlankFigure">} figure @returns {Cell} */
const cellOf = ({ value, std_error, interval, bias_bound, conformity }) => ({
  value,
  error: std_error,
  interval,
  bias: bias_bound,
  conformity,
});

/** @param {ReportData} data @param {FlankFigureName} name */
function fittedFigure({ iteration: { fits } }, name) {
  return fits.find(({ chosen }) => chosen)?.figures?.[/** @type {const} */ (`${name}_um`)];
}

/** Counts the iterations that have a figure. @param {readonly Row[]} rows */
function covered(rows) {
  return rows[0]?.cells.filter((_, i) => rows.some(({ cells }) => cells[i])).length ?? 0;
}

/** Returns a figure with its error, if there is one: of the own correction, or of the previous one that this iteration measured. @param {ReportData} data @param {FlankFigureName} name @returns {Cell | undefined} */
function ofNodes({ correction, measuredCorrection }, name) {
  const own = /** @type {const} */ (`${name}_um`);
  const estimated =
    measuredCorrection?.answer?.figure_changes?.[own]?.measured ?? correction?.answer?.figure_changes?.[own]?.before;
  if (estimated) return { value: estimated.value_um, error: estimated.std_error_um, interval: estimated.interval_um };
  const wanted = correction?.result.figures?.left ?? correction?.result.figures?.right;
  const figure = wanted?.[own];
  return figure ? { value: figure.before, error: figure.std_error } : undefined;
}

/** @param {ReportData} data @param {FlankFigureName} name @returns {Cell | undefined} */
function ofTraces(data, name) {
  const figure = tracedFigure(data, name);
  return figure && cellOf(figure);
}

/** Returns a figure of the surface through the traces of the measured tooth flank. @param {ReportData} data @param {FlankFigureName} name */
function tracedFigure({ evaluated, iteration: { tooth, flank } }, name) {
  const surface = evaluated?.result.surfaces.find((one) => one.tooth === tooth && one.flank === flank);
  return surface?.[/** @type {const} */ (`${name}_um`)] ?? undefined;
}

const TRACE = /** @type {const} */ ({
  profile: { slope: "f_Hα", total: "F_α" },
  helix: { slope: "f_Hβ", total: "F_β" },
});

/** Returns means over the teeth of evaluated traces; empty without an evaluation. @param {readonly ReportData[]} data @returns {Row[]} */
export function traceRows(data) {
  return /** @type {const} */ (["profile", "helix"]).flatMap((kind) =>
    /** @type {const} */ (["left", "right"]).flatMap((flank) =>
      /** @type {const} */ (["slope", "total"]).flatMap((what) => {
        const cells = data.map((one) => traceCell(one, kind, flank, what));
        if (cells.every((cell) => cell === undefined)) return [];
        const limits =
          what === "slope"
            ? data.flatMap((one) => limitsOf(conformities(tracesOf(one, kind, flank)))).at(-1)
            : undefined;
        return [
          {
            key: `${kind} ${flank} ${what}`,
            symbol: TRACE[kind][what],
            name: /** @type {const} */ (`trace_${what}`),
            flank,
            cells,
            change: undefined,
            limits,
          },
        ];
      }),
    ),
  );
}

/** @param {ReportData} data @param {"profile" | "helix"} kind @param {"left" | "right"} flank */
function tracesOf({ evaluated }, kind, flank) {
  return (evaluated?.result.traces ?? []).filter((trace) => trace.kind === kind && trace.flank === flank);
}

/** @param {ReportData} data @param {"profile" | "helix"} kind @param {"left" | "right"} flank @param {"slope" | "total"} what @returns {Cell | undefined} */
function traceCell(data, kind, flank, what) {
  const mean = data.evaluated?.result.means.find((one) => one.kind === kind && one.flank === flank)?.[`${what}_um`]
    .mean;
  const traces = tracesOf(data, kind, flank);
  if (typeof mean !== "number") return undefined;
  const classes = traces.flatMap(({ class: of }) => (typeof of?.[what] === "number" ? [of[what]] : []));
  const alone = traces.length === 1 ? traces[0] : undefined;
  return {
    value: mean,
    // the response has errors of single traces, not of their mean
    error: what === "slope" ? (alone?.slope_std_error_um ?? undefined) : undefined,
    class: classes.length > 0 ? Math.max(...classes) : undefined,
    conformity: what === "slope" ? worst(traces) : undefined,
  };
}

const WORST = /** @type {const} */ (["does_not_conform", "undecidable", "doubtful", "conforms"]);

/** Returns the conformity of the worst trace. @param {readonly EvaluatedTrace[]} traces @returns {Conformity | undefined} */
function worst(traces) {
  const found = traces.flatMap(({ slope_conformity: one }) => one ?? []);
  const rank = (/** @type {Conformity} */ one) => WORST.indexOf(verdictOf(one).key);
  return found.sort((a, b) => rank(a) - rank(b))[0];
}

/** @param {readonly EvaluatedTrace[]} traces */
const conformities = (traces) => traces.map(({ slope_conformity: conformity }) => ({ conformity }));

/** @param {readonly ({ conformity?: Conformity | undefined } | undefined)[]} figures @returns {Limits[]} */
function limitsOf(figures) {
  return figures.flatMap((one) => {
    const [low, high] = one?.conformity?.limits_um ?? [];
    return low === undefined || high === undefined ? [] : [{ low, high }];
  });
}

/** Returns the least and greatest height of the nodes. @param {ReportData} data */
export function heightsOf({ surface }) {
  const ends = surface && extremesOf(surface);
  return ends ? { low: ends.least.z, high: ends.greatest.z } : undefined;
}

/** Returns the coarsest class of an evaluation; 12 for anything above class 11. @param {ReportData} data */
export function coarsest({ evaluated }) {
  if (!evaluated) return undefined;
  return evaluated.result.coarser_than_11 ? 12 : (evaluated.result.class ?? undefined);
}
