// A correction as it is typed, and its request. Pure.

import { parseNumber } from "./format.js";

/** @typedef {import("../api/client.js").Schema<"CorrectionRequest">} CorrectionRequest */
/** @typedef {import("../api/client.js").Schema<"SettingLimits">} SettingLimits */
/** @typedef {{ fixed: boolean, min: string, max: string, increment: string }} LimitDraft */
/**
 * @typedef {object} Draft everything as text, as it was typed
 * @property {"form_grinding" | "generating_grinding" | "matrix"} by
 * @property {"" | "left" | "right"} flank
 * @property {"" | "roll_length" | "roll_angle" | "diameter"} axis
 * @property {string} matrix names with units in its first line, below it a line for each node
 * @property {string} noise
 * @property {string} response
 * @property {"" | "true" | "false"} absolute
 * @property {"" | "design" | "limits" | "nominal" | "given"} aim
 * @property {string} target the target deviations, if they are given
 * @property {"" | "needed" | "all"} used
 * @property {Record<string, LimitDraft>} limits
 */

/** Settings of the machines that are known by name, with their units; docs/reference/machine-settings.md shows each. */
export const MACHINES = /** @type {const} */ ({
  form_grinding: {
    profile_angle: "arcmin",
    helix_angle: "arcmin",
    profile_crowning: "µm",
    helix_crowning: "µm",
    tooth_thickness: "µm",
    infeed: "µm",
    tool_axis_offset: "µm",
  },
  generating_grinding: {
    profile_angle: "arcmin",
    helix_angle: "arcmin",
    profile_crowning: "µm",
    helix_crowning: "µm",
    twist: "µm",
    tooth_thickness: "µm",
    tool_axis_offset: "µm",
  },
});

/** @typedef {keyof typeof MACHINES.form_grinding | keyof typeof MACHINES.generating_grinding} SettingName */

/** @type {LimitDraft} */
const FREE = { fixed: false, min: "", max: "", increment: "" };

/** @param {Draft} draft @param {string} name */
export const limitOf = (draft, name) => draft.limits[name] ?? FREE;

/** @param {boolean} hasGear without one there is no machine @returns {Draft} */
export function emptyDraft(hasGear) {
  return {
    by: hasGear ? "form_grinding" : "matrix",
    flank: "",
    axis: "",
    matrix: "",
    noise: "",
    response: "",
    absolute: "",
    aim: "",
    target: "",
    used: "",
    limits: {},
  };
}

/**
 * Returns the draft that a request came from, to begin another one.
 * @param {CorrectionRequest} request @param {(value: number | null | undefined) => string} write
 * @returns {Draft}
 */
export function draftOf(request, write) {
  const { sensitivity, limits = {} } = request;
  const machine = sensitivity.type === "machine" ? sensitivity : undefined;
  const given = sensitivity.type === "matrix" ? sensitivity : undefined;
  const units = given?.units ?? [];
  const head = (given?.settings ?? []).map((name, i) => (units[i] ? `${name} [${units[i]}]` : name)).join("\t");
  // a stored request has its matrix only if the nodes are included
  const matrix = given?.matrix ?? [];
  const list = (/** @type {readonly (number | null)[] | undefined} */ values) => (values ?? []).map(write).join("\n");
  return {
    by: machine?.machine ?? "matrix",
    flank: machine?.flank ?? "",
    axis: machine?.profile_axis ?? "",
    matrix: matrix.length > 0 ? [head, ...matrix.map((row) => row.map(write).join("\t"))].join("\n") : "",
    noise: write(request.noise_sigma_um),
    response: write(request.response_uncertainty),
    absolute: request.absolute === undefined || request.absolute === null ? "" : request.absolute ? "true" : "false",
    aim: aimOf(request.target),
    target: typeof request.target === "object" ? list(request.target?.deviation_um) : "",
    used: request.settings_used ?? "",
    limits: Object.fromEntries(
      Object.entries(limits).map(([name, { fixed, min, max, increment }]) => [
        name,
        { fixed: fixed ?? false, min: write(min), max: write(max), increment: write(increment) },
      ]),
    ),
  };
}

/** @param {CorrectionRequest["target"]} target @returns {Draft["aim"]} */
function aimOf(target) {
  if (target === undefined || target === null) return "";
  return typeof target === "string" ? target : "given";
}

/** Returns the settings that a draft names, with their units. @param {Draft} draft @returns {{ name: string, unit: string | undefined }[]} */
export function settingsOf(draft) {
  if (draft.by === "matrix") return headOf(draft.matrix);
  return Object.entries(MACHINES[draft.by]).map(([name, unit]) => ({ name, unit }));
}

/** @param {string} text */
function headOf(text) {
  const line = text.split(/\r?\n/).find((one) => one.trim() !== "") ?? "";
  return cellsOf(line).map((cell) => {
    const [, name = cell, unit] = /^(.*?)\s*\[(.*)\]$/.exec(cell) ?? [];
    return { name, unit };
  });
}

/** Splits cells at tabs, semicolons or, if there is neither, commas. @param {string} line */
function cellsOf(line) {
  const between = /[\t;]/.test(line) ? /[\t;]/ : /,/;
  return line.split(between).map((cell) => cell.trim());
}

/** @typedef {{ request: CorrectionRequest, errors: Record<string, "number" | "row"> }} Read `errors`: pointers of invalid numbers */

/**
 * Returns the request of a draft, and the places of invalid numbers.
 * @param {Draft} draft @returns {Read}
 */
export function requestOf(draft) {
  /** @type {Read["errors"]} */
  const errors = {};
  const number = (/** @type {string} */ text, /** @type {string} */ pointer) => {
    const value = parseNumber(text);
    if (value !== undefined && Number.isNaN(value)) errors[pointer] = "number";
    return value;
  };
  const known = new Set(settingsOf(draft).map(({ name }) => name));
  /** @type {Record<string, SettingLimits>} */
  const limits = {};
  for (const [name, { fixed, ...typed }] of Object.entries(draft.limits)) {
    if (!known.has(name)) continue;
    if (fixed) {
      limits[name] = { fixed: true };
      continue;
    }
    const said = Object.entries(typed)
      .map(([what, text]) => [what, number(text, `/limits/${escaped(name)}/${what}`)])
      .filter(([, value]) => value !== undefined);
    if (said.length > 0) limits[name] = Object.fromEntries(said);
  }
  const noise = number(draft.noise, "/noise_sigma_um");
  const response = number(draft.response, "/response_uncertainty");
  const words = draft.aim === "given" ? draft.target.split(/[\s;]+/).filter(Boolean) : [];
  const wanted = words.map((word) => number(word, "/target") ?? 0);
  const target = draft.aim === "given" ? { deviation_um: wanted } : draft.aim;
  /** @type {CorrectionRequest} */
  const request = {
    sensitivity: draft.by === "matrix" ? matrixOf(draft.matrix, errors) : machineOf(draft, draft.by),
    ...(Object.keys(limits).length > 0 ? { limits } : {}),
    ...(noise === undefined ? {} : { noise_sigma_um: noise }),
    ...(response === undefined ? {} : { response_uncertainty: response }),
    ...(draft.absolute === "" ? {} : { absolute: draft.absolute === "true" }),
    ...(target === "" ? {} : { target }),
    ...(draft.used === "" ? {} : { settings_used: draft.used }),
  };
  return { request, errors };
}

/**
 * @param {Draft} draft @param {Exclude<Draft["by"], "matrix">} machine
 * @returns {CorrectionRequest["sensitivity"]}
 */
function machineOf({ flank, axis }, machine) {
  return { type: "machine", machine, ...(flank ? { flank } : {}), ...(axis ? { profile_axis: axis } : {}) };
}

/** @param {string} text @param {Read["errors"]} errors @returns {CorrectionRequest["sensitivity"]} */
function matrixOf(text, errors) {
  const lines = text.split(/\r?\n/).filter((line) => line.trim() !== "");
  const head = headOf(text);
  const matrix = lines.slice(1).map((line) => cellsOf(line).map((cell) => parseNumber(cell) ?? Number.NaN));
  const wrong = matrix.findIndex((row) => row.some(Number.isNaN));
  if (wrong >= 0) errors["/sensitivity/matrix"] = "row";
  const units = head.map(({ unit }) => unit ?? "");
  return {
    type: "matrix",
    settings: head.map(({ name }) => name),
    ...(units.every(Boolean) && units.length > 0 ? { units } : {}),
    matrix,
  };
}

/** Escapes a name for a JSON Pointer. @param {string} name */
export const escaped = (name) => name.replaceAll("~", "~0").replaceAll("/", "~1");

/**
 * Returns true if a change is distinguishable from zero: greater than the half width of its 95 %
 * interval.
 * @param {Pick<import("../api/client.js").Schema<"SettingChange">, "change" | "std_error">} setting
 */
export const significant = ({ change, std_error }) => Math.abs(change) > 1.96 * (std_error ?? 0);

/**
 * Returns the value after a change, from texts: the previous value and the change.
 * @param {string} present @param {string} change
 * @returns {number | undefined} none where one of them is no number
 */
export function newValue(present, change) {
  const sum = (parseNumber(present) ?? Number.NaN) + (parseNumber(change) ?? Number.NaN);
  return Number.isNaN(sum) ? undefined : Number(sum.toPrecision(12));
}

/** `present`: before the correction; `next`: after it, once it was entered. @typedef {{ correction: string, present: string, next: string }} Present */

/** Returns the value on the machine before a correction: after another correction, its new value. @param {Present | undefined} kept @param {string} correction */
export const presentOf = (kept, correction) => (kept?.correction === correction ? kept.present : kept?.next) ?? "";

/**
 * Returns true if a stored value belongs to another time than before this correction: to a later
 * correction, or to another one although this one was entered. IDs of corrections grow with time.
 * @param {Present | undefined} kept @param {string} correction @param {boolean} entered
 */
export const isSuperseded = (kept, correction, entered) =>
  kept !== undefined && kept.correction !== correction && (entered || kept.correction > correction);
