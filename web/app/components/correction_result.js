// A correction: the changes at the machine, the prediction, and the result.

import { Strip, StripLegend } from "../charts/strip.js";
import { t } from "../i18n/correction.js";
import { fmt } from "../i18n/i18n.js";
import { unitSign } from "../lib/units.js";
import { significant } from "../lib/correction.js";
import { ABSENT } from "../lib/format.js";
import { stripDomain } from "../lib/strip.js";
import { h, html } from "../../vendor/ui.js";
import { Badge, Facts, WithError } from "./figure.js";
import { limitText } from "./flank_figures.js";
import { GearSymbol } from "./symbol.js";
import { table } from "./table.js";
import { Decided } from "./within.js";

/** @typedef {import("../api/client.js").Schema<"Correction">} Correction */
/** @typedef {import("../api/client.js").Schema<"SettingChange">} SettingChange */
/** @typedef {import("../api/client.js").Schema<"MachineAnswer">} MachineAnswer */
/** @typedef {import("../api/client.js").Schema<"EstimatedFigure">} EstimatedFigure */
/** @typedef {import("../../vendor/ui.js").ComponentChildren} Children */

const NAMES = new Set([
  "profile_angle",
  "helix_angle",
  "profile_crowning",
  "helix_crowning",
  "twist",
  "tooth_thickness",
  "infeed",
  "tool_axis_offset",
]);

/** Returns the request of a correction. @param {Correction} kept */
export const requestOf = ({ request }) =>
  /** @type {import("../api/client.js").Schema<"CorrectionRequest">} */ (/** @type {unknown} */ (request));

/** The name of a setting; those of a matrix have the caller's. @param {string} name @returns {string} */
export function settingName(name) {
  if (NAMES.has(name)) return t[/** @type {"twist"} */ (name)];
  // settings that a machine has for each flank
  const [, own = "", side] = /^(.*)_(left|right)$/.exec(name) ?? [];
  return NAMES.has(own) ? `${settingName(own)}, ${t[/** @type {"left"} */ (side)]}` : name;
}

/** @param {string} name */
const settingCell = (name) =>
  settingName(name) !== name
    ? html`${settingName(name)} <code class="quiet" translate="no">${name}</code>`
    : html`<span translate="no">${name}</span>`;

/** Replaces the sign for minutes by the word: the sign is too small to be read. @param {string | null | undefined} unit */
const sign = (unit) => (unit === "arcmin" || unit === "′" ? "arcmin" : (unitSign(unit) ?? ""));

/** Joins the degree sign to its number. @param {string | null | undefined} unit */
export const unitOf = (unit) => (unit === "deg" ? sign(unit) : `\u202f${sign(unit)}`);

/** A change as it is entered: all digits of its step, else to the second digit of its error. @param {SettingChange} setting */
function entered({ change, rounded, limited, fixed, undetermined, unchanged, std_error }) {
  const { value } = fmt;
  if (unchanged) return t.leave;
  if (fixed || (undetermined && change === 0)) return ABSENT;
  const signed = (/** @type {string} */ text) => (change > 0 ? `+${text}` : text);
  if (rounded || limited) return signed(value.input(Number(change.toPrecision(12))).replace("-", "−"));
  return signed(std_error ? value.deviation(change, undefined, std_error) : value.three(change));
}

/** A proposed change as the initial text of the form for entered changes. @param {SettingChange} setting */
export function proposedText(setting) {
  const text = setting.unchanged ? ABSENT : entered(setting);
  return text === ABSENT ? "0" : text.replace(/^\+/, "");
}

/** @param {SettingChange} setting @returns {Children} */
function notesOf({ unit, limited, fixed, rounded, unrounded, unlimited, std_error }) {
  const { value } = fmt;
  const text = (/** @type {number} */ number) => value.withError(number, std_error, sign(unit));
  return html`<span class="notes">
    ${limited && h(Badge, { kind: "warn", children: t.atLimit })}
    ${fixed && h(Badge, { kind: "plain", children: t.fixed })}
    ${rounded && unrounded !== undefined && unrounded !== null && html`<span>${t.rounded(text(unrounded))}</span>`}
    ${unlimited !== undefined && unlimited !== null && limited && html`<span>${t.unlimited(text(unlimited))}</span>`}
  </span>`;
}

/** Reasons for which settings stay or their changes mean little, each once. @param {{ settings: readonly SettingChange[] }} props */
function Reasons({ settings }) {
  /** @param {(setting: SettingChange) => unknown} of */
  const names = (of) =>
    settings
      .filter(of)
      .map(({ name }) => settingName(name))
      .join("; ");
  const reasons = [
    { reason: t.not_distinguishable, of: names((one) => one.unchanged === "not_distinguishable" || isUnsure(one)) },
    { reason: t.within_limits, of: names(({ unchanged }) => unchanged === "within_limits") },
    { reason: t.undetermined, of: names(({ undetermined }) => undetermined) },
  ].filter(({ of }) => of !== "");
  return html`${reasons.map(({ reason, of }) => html`<span key=${reason} class="reason">${reason}: ${of}.</span> `)}`;
}

/** Returns true for a change that is made although it is indistinguishable from zero. @param {SettingChange} setting */
const isUnsure = (setting) => !isIdle(setting) && !setting.limited && !significant(setting);

/** @param {SettingChange} setting */
const isIdle = ({ fixed, undetermined, unchanged }) => Boolean(fixed || undetermined || unchanged);

/** A change for drawing; undefined if none was required. @param {SettingChange} setting */
const drawnOf = ({ change, std_error, bias_bound, fixed, undetermined, unchanged }) =>
  fixed || unchanged || (undetermined && change === 0) ? [] : [{ value: change, error: std_error, bias: bias_bound }];

/** Names the settings from which one is indistinguishable. @param {Correction["result"]} result @param {string} name */
function inseparableFrom({ indistinguishable }, name) {
  const others = new Set(indistinguishable.flatMap(({ names }) => (names.includes(name) ? names : [])));
  others.delete(name);
  return [...others].map(settingName).join(", ");
}

/** @param {{ result: Correction["result"], csvName?: string | undefined, tools: Children, of?: string }} props `of`: says whose they are, where there are several */
export function Changes({ result, csvName, tools, of }) {
  const { value } = fmt;
  const { settings } = result;
  return table({
    caption: of ? `${t.changes}, ${of}` : t.changes,
    hideCaption: true,
    csvName,
    tools,
    stacked: true,
    rows: settings,
    rowKey: ({ name }) => name,
    note: html`${h(Reasons, { settings })}${h(StripLegend, { estimates: settings.flatMap(drawnOf) })}`,
    rowClass: (row) => (isIdle(row) ? "idle" : isUnsure(row) ? "unsure" : ""),
    columns: [
      {
        key: "name",
        header: t.setting,
        rowHeader: true,
        cell: ({ name }) => {
          const others = inseparableFrom(result, name);
          return html`${settingCell(name)} ${others && html`<span class="inseparable">${t.inseparable(others)}</span>`}`;
        },
        csv: ({ name }) => name,
      },
      {
        key: "change",
        header: t.change,
        numeric: true,
        cell: (row) => {
          const text = entered(row);
          return html`<b class="change" translate="no">${text}${row.unchanged || text === ABSENT ? "" : unitOf(row.unit)}</b>`;
        },
        csv: ({ change }) => change,
      },
      {
        key: "error",
        header: t.error,
        numeric: true,
        cell: ({ std_error, unit }) => data(std_error ? `± ${value.significant(std_error, 2)}${unitOf(unit)}` : ABSENT),
        csv: ({ std_error }) => std_error,
      },
      {
        key: "bound",
        header: t.bound,
        numeric: true,
        minor: true,
        cell: ({ bias_bound, unit }) =>
          data(typeof bias_bound === "number" ? `${value.significant(bias_bound, 2)}${unitOf(unit)}` : ABSENT),
        csv: ({ bias_bound }) => bias_bound,
      },
      {
        key: "strip",
        header: t.drawn,
        minor: true,
        cell: (row) => {
          const estimates = drawnOf(row);
          // the distance from no change
          const domain = stripDomain([...estimates, { value: 0 }]);
          return h(Strip, { estimates, unit: unitSign(row.unit) ?? "", domain });
        },
      },
      { key: "notes", header: t.notes, cell: notesOf, csv: ({ limited }) => (limited ? t.atLimit : "") },
    ],
  });
}

/** The facts of a correction. @param {Correction} kept */
export function factsOf({ method, result, created_at }) {
  const known = method === "form_grinding" || method === "generating_grinding" || method === "matrix";
  return [
    { name: t.madeBy, value: known ? t[/** @type {"matrix"} */ (method)] : data(method) },
    { name: t.aim, value: t[`aim_${result.target.kind}`] },
    { name: t.madeAt, value: data(fmt.value.time(created_at)) },
  ];
}

/** The settings that are indistinguishable. @param {{ result: Correction["result"] }} props */
export function Indistinguishable({ result }) {
  return html`<ul class="sentences">
    ${result.indistinguishable.map(({ names, condition_index }) => {
      const all = names.map(settingName);
      const said = [all.slice(0, -1).join(", "), all.at(-1)].filter(Boolean).join(` ${t.and} `);
      const index = condition_index ? fmt.value.condition(condition_index) : undefined;
      return html`<li key=${said} class="note warn">${t.indistinguishableSentence(said, index)}</li>`;
    })}
  </ul>`;
}

const FIGURES = /** @type {const} */ ([
  ["profile_slope", "f_Hα", "profile_slope"],
  ["helix_slope", "f_Hβ", "helix_slope"],
  ["profile_crowning", "C_α", "profile_crowning_figure"],
  ["helix_crowning", "C_β", "helix_crowning_figure"],
  ["twist", "S", "twist_figure"],
]);

/** @typedef {import("../api/client.js").Schema<"CorrectionTargetFigure">} TargetFigure */
/** @typedef {{ key: string, name: string, symbol?: string, before?: EstimatedFigure, wanted?: TargetFigure, predicted?: number, measured?: EstimatedFigure, change?: EstimatedFigure, lessPredicted?: EstimatedFigure }} FigureRow */

/** @param {Correction} kept @returns {FigureRow[]} */
function figureRows({ result, answer }) {
  const wanted = result.figures?.left ?? result.figures?.right;
  const plain = (/** @type {number | null | undefined} */ value) =>
    typeof value === "number" ? { value_um: value } : undefined;
  const estimated = (/** @type {TargetFigure | null | undefined} */ figure) =>
    figure ? { value_um: figure.before, ...(figure.std_error ? { std_error_um: figure.std_error } : {}) } : undefined;
  const figures = FIGURES.map(([key, symbol, word]) => {
    const own = /** @type {const} */ (`${key}_um`);
    const changes = answer?.figure_changes?.[own];
    return given({
      key,
      symbol,
      name: t[word],
      before: changes?.before ?? estimated(wanted?.[own]),
      wanted: wanted?.[own] ?? undefined,
      predicted: changes?.predicted_um ?? wanted?.[own]?.predicted ?? undefined,
      measured: changes?.measured,
      change: changes?.change,
      lessPredicted: changes?.difference,
    });
  }).filter(({ before: had, predicted }) => had !== undefined || predicted !== undefined);
  const { predicted } = result;
  return [
    ...figures,
    given({
      key: "rms",
      name: t.rms,
      before: plain(answer?.rms_before_um ?? predicted.rms_before_um),
      predicted: answer?.rms_predicted_um ?? predicted.rms_um,
      measured: plain(answer?.rms_measured_um),
    }),
    given({ key: "max", name: t.greatest, before: plain(predicted.max_before_um), predicted: predicted.max_um }),
  ];
}

/**
 * Returns the part of a correction for one flank.
 * @param {Correction} kept @param {"left" | "right"} side @param {import("../api/client.js").Schema<"CorrectionTargetFigures">} own its figures
 * @param {MachineAnswer["figure_changes"]} [changes] of them, once they were measured again
 * @returns {Correction}
 */
export function ofFlank({ answer: measured, result, ...kept }, side, own, changes) {
  return {
    ...kept,
    ...(measured && changes ? { answer: { ...measured, figure_changes: changes } } : {}),
    result: { ...result, figures: { [side]: own } },
  };
}

/** Removes undefined members. @param {{ [Key in keyof FigureRow]: FigureRow[Key] | undefined }} row */
function given(row) {
  return /** @type {FigureRow} */ (Object.fromEntries(Object.entries(row).filter(([, value]) => value !== undefined)));
}

/** Before, predicted and measured, drawn below each other. */
const SERIES = /** @type {const} */ ([
  { key: "before", series: "blue", sign: "circle" },
  { key: "predicted", series: "purple", sign: "square" },
  { key: "measured", series: "vermilion", sign: "diamond" },
]);

/** @param {FigureRow} row */
const drawnFigure = (row) =>
  SERIES.flatMap(({ key, series, sign }) => {
    const { predicted } = row;
    /** @type {EstimatedFigure | undefined} */
    const of = key !== "predicted" ? row[key] : predicted === undefined ? undefined : { value_um: predicted };
    if (!of) return [];
    return [{ name: t[key], value: of.value_um, error: of.std_error_um, interval: of.interval_um, series, sign }];
  });

/** Symbols of the figures that would lie outside their limits after the correction. @param {Correction["result"]} result */
export function outsideOf({ figures }) {
  const sides = [figures?.left, figures?.right];
  const outside = FIGURES.filter(([key]) =>
    sides.some((side) => {
      const figure = side?.[/** @type {"twist_um"} */ (`${key}_um`)];
      const [low = -Infinity, high = Infinity] = figure?.limits ?? [];
      return figure && (figure.predicted < low || figure.predicted > high);
    }),
  );
  return outside.map(([, symbol]) => symbol.replace("_", ""));
}

/** A value with its conformity. @param {Children} value @param {TargetFigure["conformity_before"]} conformity */
const decided = (value, conformity) => html`${value} ${h(Decided, { conformity })}`;

/** @param {{ kept: Correction, csvName?: string | undefined, of?: string }} props `of`: the flank, where there are several */
export function Figures({ kept, csvName, of }) {
  const { value } = fmt;
  const um = "µm";
  const estimated = (/** @type {EstimatedFigure | undefined} */ figure) =>
    figure?.std_error_um
      ? h(WithError, { value: figure.value_um, error: figure.std_error_um })
      : data(value.deviation(figure?.value_um, um));
  /** @param {"before" | "measured" | "change" | "lessPredicted"} key @param {string} header @returns {import("./table.js").Column<FigureRow>} */
  const column = (key, header) => ({
    key,
    header,
    unit: um,
    numeric: true,
    cell: (row) => estimated(row[key]),
    csv: (row) => row[key]?.value_um,
  });
  /** @type {import("./table.js").Column<FigureRow>[]} */
  const columns = [
    {
      key: "figure",
      header: t.figure,
      rowHeader: true,
      cell: ({ name, symbol }) => html`${symbol && html`${h(GearSymbol, { name: symbol })} `}${name}`,
      csv: ({ name, symbol }) => (symbol ? `${symbol} ${name}` : name),
    },
    {
      ...column("before", t.before),
      cell: (row) => decided(estimated(row.before), row.wanted?.conformity_before),
    },
    {
      key: "wanted",
      header: t.wantedFigure,
      unit: um,
      numeric: true,
      minor: Boolean(kept.answer),
      cell: ({ wanted, before }) => data(value.deviation(wanted?.target, um, before?.std_error_um)),
      csv: ({ wanted }) => wanted?.target,
    },
    {
      key: "predicted",
      header: t.predicted,
      unit: um,
      numeric: true,
      // a measured change has no error of its own: it is as certain as the measurement
      cell: ({ predicted, before, wanted }) =>
        decided(data(value.deviation(predicted, um, before?.std_error_um)), wanted?.conformity_predicted),
      csv: ({ predicted }) => predicted,
    },
  ];
  // RMS and greatest deviation cover both flanks, not one of them
  const rows = figureRows(kept).filter(({ symbol }) => symbol || !of);
  if (kept.answer) {
    columns.push(
      column("measured", t.measured),
      { ...column("change", t.changed), minor: true, screen: true },
      column("lessPredicted", t.lessPredicted),
      {
        key: "interval",
        header: t.lessPredictedInterval,
        unit: um,
        numeric: true,
        minor: true,
        screen: true,
        cell: ({ lessPredicted }) => data(value.interval(lessPredicted?.interval_um, lessPredicted?.std_error_um)),
        csv: ({ lessPredicted }) => lessPredicted?.interval_um,
      },
    );
  }
  if (rows.some(({ wanted }) => wanted?.limits))
    columns.push({
      key: "limits",
      header: t.limits_figure,
      unit: um,
      numeric: true,
      cell: ({ wanted }) => data(limitText(wanted?.limits ?? undefined)),
      csv: ({ wanted }) => wanted?.limits?.join(" … "),
    });
  const drawn = rows.filter(({ symbol }) => symbol);
  if (drawn.length > 0)
    columns.push({
      key: "strip",
      header: t.drawn,
      screen: true,
      minor: true,
      cell: (row) =>
        row.symbol && h(Strip, { estimates: drawnFigure(row), limits: row.wanted?.limits ?? undefined, unit: um }),
    });
  const named = SERIES.filter(({ key }) => drawn.some((row) => row[key] !== undefined)).map((one) => ({
    ...one,
    name: t[one.key],
  }));
  return table({
    note:
      drawn.length > 0 &&
      h(StripLegend, {
        estimates: drawn.flatMap(drawnFigure),
        limited: drawn.some(({ wanted }) => wanted?.limits),
        named,
      }),
    caption: [kept.answer ? t.figures : t.figuresBefore, of].filter(Boolean).join(", "),
    hideCaption: true,
    columns,
    rows,
    rowKey: ({ key }) => key,
    csvName,
    stacked: true,
  });
}

/** The response of the machine. @param {{ answer: MachineAnswer, entered: boolean }} props `entered`: compared with the entered changes */
export function Answer({ answer, entered }) {
  const { value } = fmt;
  const kind = {
    as_predicted: "good",
    weaker: "warn",
    no_response: "bad",
    stronger: "warn",
    different: "bad",
    undecided: "plain",
  };
  const { verdict, response_ratio: ratio, response_ratio_std_error: error, not_entered: omitted } = answer;
  const names = omitted?.map(({ setting }) => settingName(setting));
  const um = "\u202fµm";
  return html`<p class="verdict">
      ${h(Badge, { kind: /** @type {"good"} */ (kind[verdict]), children: entered ? t.ofEntered(t[verdict]) : t[verdict] })} ${names?.length ? t.notEntered(names) : t[`sentence_${verdict}`]}
    </p>
    ${h(Facts, {
      items: [
        {
          name: t.ratio,
          value: typeof ratio === "number" ? h(WithError, { value: ratio, error }) : t.ratioUnknown,
          note: t.ratioNote,
        },
        { name: `${t.ratio}, ${t.interval95}`, value: data(value.interval(answer.response_ratio_interval, error)) },
        {
          name: t.difference,
          value: data(value.um(answer.rms_difference_um) + um),
          note: t.expected(value.um(answer.rms_expected_difference_um) + um),
        },
        {
          name: t.chiSquared,
          value: data(value.three(answer.chi_squared)),
          note: t.chiLimit(value.three(answer.chi_squared_limit)),
        },
        { name: t.compared, value: data(value.count(answer.nodes)) },
      ],
    })}`;
}

/** @param {string} text */
const data = (text) => html`<span translate="no">${text}</span>`;
