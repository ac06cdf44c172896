// The input of the fields next to the files, and the request made of it. Pure.

import { parseNumber } from "../lib/format.js";
import { namesAxes } from "../lib/nodes_table.js";
import { likelyAlong, likelyFlank, likelyUnit } from "./likely.js";

/** @typedef {import("../api/client.js").Schemas} Schemas */
/** @typedef {import("./read.js").Content} Content */
/** The contents of the fields; texts as they were typed. */
export const EMPTY = {
  model: "second",
  degreeU: "2",
  degreeV: "2",
  estimator: "least_squares",
  regularization: "default",
  conditionLimit: "",
  hampel: "off",
  gaussian: "off",
  cutoff: "",
  axes: "",
  unit: "",
  flank: "",
  tooth: "",
  component: "",
  instrument: "",
  operator: "",
  measuredAt: "",
  note: "",
  text: "",
};
/** @typedef {typeof EMPTY} Typed */

/**
 * Returns the input, with the most likely values of the fields left empty.
 * @param {Typed} typed @param {Content} content @param {{ name: string, gear: import("./likely.js").Gear | null | undefined }} of
 * @returns {Typed}
 */
export function answered(typed, content, { name, gear }) {
  if (content.kind === "import") return typed;
  // named columns define the axes
  if (namesAxes(content.proposal)) return { ...typed, flank: typed.flank || likelyFlank(name), axes: "", unit: "" };
  const own = content.request?.["flank"] !== undefined;
  return {
    ...typed,
    flank: typed.flank || (own ? "" : likelyFlank(name)),
    axes: typed.axes || (likelyAlong(content.surface, gear) ?? "none"),
    unit: typed.unit || likelyUnit(content.surface),
  };
}

/** Returns the fields with invalid numbers. @param {Typed} typed @returns {Partial<Record<keyof Typed, true>>} */
export function wrongNumbers(typed) {
  /** @type {Partial<Record<keyof Typed, true>>} */
  const wrong = {};
  const degree = (/** @type {string} */ text) => /^\d{1,2}$/.test(text.trim());
  if (typed.model === "other" && !degree(typed.degreeU)) wrong.degreeU = true;
  if (typed.model === "other" && !degree(typed.degreeV)) wrong.degreeV = true;
  if (Number.isNaN(parseNumber(typed.conditionLimit))) wrong.conditionLimit = true;
  const cutoff = parseNumber(typed.cutoff);
  if (typed.gaussian !== "off" && !(cutoff !== undefined && cutoff > 0)) wrong.cutoff = true;
  if (typed.measuredAt !== "" && Number.isNaN(Date.parse(typed.measuredAt))) wrong.measuredAt = true;
  return wrong;
}

/**
 * Returns the request without nodes. A JSON file's own fit applies to fields that keep their
 * initial values.
 * @param {Typed} typed @param {Content} content @returns {Record<string, unknown>}
 */
export function specOf(typed, content) {
  const { nodes: _, ...file } = content.request ?? {};
  /** @type {Record<string, unknown>} */
  const spec = { ...file };
  const curve = content.form === "curve";
  const own = (/** @type {keyof Typed} */ key, /** @type {string} */ name) =>
    typed[key] !== EMPTY[key] || !(name in file);
  if (own("model", "model")) {
    const [p, q] = typed.model === "other" ? [Number(typed.degreeU), Number(typed.degreeV)] : [2, 2];
    spec["model"] = { type: "polynomial", degree: curve ? p : [p, q], basis: "legendre" };
  }
  if (own("estimator", "estimator")) spec["estimator"] = estimatorOf(typed.estimator);
  if (own("regularization", "regularization") || typed.conditionLimit.trim() !== "") {
    const regularization = regularizationOf(typed);
    if (regularization) spec["regularization"] = regularization;
  }
  const filters = filtersOf(typed, curve);
  if (filters.length > 0) spec["filters"] = filters;
  if (typed.axes !== "" && typed.axes !== "none" && !("axes" in file)) spec["axes"] = axesOf(typed, curve);
  if (!("include" in file)) spec["include"] = ["collinearity"];
  for (const name of /** @type {const} */ (["flank", "tooth", "instrument", "operator", "note"])) {
    if (typed[name].trim() !== "") spec[name] = typed[name].trim();
  }
  if (typed.measuredAt !== "") spec["measured_at"] = new Date(typed.measuredAt).toISOString();
  return spec;
}

/** Returns the fields of an imported file. @param {Typed} typed */
export function importSpecOf(typed) {
  const names = /** @type {const} */ (["flank", "tooth", "component", "note"]);
  return Object.fromEntries(names.flatMap((name) => (typed[name].trim() === "" ? [] : [[name, typed[name].trim()]])));
}

/** @param {string} name */
function estimatorOf(name) {
  if (name === "huber" || name === "tukey") return { type: "m_estimator", loss: name };
  return { type: name };
}

/** @param {Typed} typed */
function regularizationOf({ regularization, conditionLimit }) {
  const limit = parseNumber(conditionLimit);
  const limited = limit === undefined ? {} : { condition_limit: limit };
  if (regularization === "none") return { type: "none" };
  if (regularization === "ridge") return { type: "ridge" };
  if (regularization === "default") return limit === undefined ? undefined : { type: "spectral", ...limited };
  return { type: "spectral", ...limited, lambda_star: { criterion: regularization } };
}

/** @param {Typed} typed @param {boolean} curve */
function filtersOf({ hampel, gaussian, cutoff }, curve) {
  const filters = [];
  if (hampel === "on") filters.push({ type: "hampel" });
  if (gaussian !== "off") {
    filters.push({ type: "gaussian", cutoff: parseNumber(cutoff), ...(curve ? {} : { axis: gaussian }) });
  }
  return filters;
}

/** Axes of a table without named columns. @param {Pick<Typed, "axes" | "unit">} typed @param {boolean} curve */
export function axesOf({ axes, unit }, curve) {
  const heights = { quantity: "deviation", unit: unit || "um" };
  const profile = { quantity: axes, unit: "mm" };
  return curve ? { x: profile, y: heights } : { u: profile, v: { quantity: "face_width", unit: "mm" }, z: heights };
}

/** Returns the node that a pointer of a grid names, from 0. @param {string} pointer */
export function nodeOfPointer(pointer) {
  const found = /^\/nodes\/(?:z|weight|valid)\/(\d+)\/(\d+)$/.exec(pointer);
  return found ? { row: Number(found[1]), column: Number(found[2]) } : undefined;
}
