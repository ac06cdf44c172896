// The most likely measurand of a table of nodes, and its meaning in words. Pure.

import { MICROMETRES } from "../lib/units.js";

/** @typedef {import("../api/client.js").Schema<"Gear">} Gear */
/** @typedef {import("../flank/surface.js").FlankSurface} FlankSurface */
/** @typedef {"roll_length" | "diameter"} Along */
/** @typedef {import("../lib/units.js").Unit} Unit */

/** Usual range of deviations of flanks, µm. */
const USUAL = [0.4, 300];

/** @param {ArrayLike<number>} values @returns {[number, number] | undefined} */
function endsOf(values) {
  let [low, high] = [Number.POSITIVE_INFINITY, Number.NEGATIVE_INFINITY];
  for (let i = 0; i < values.length; i++) {
    const value = values[i] ?? Number.NaN;
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return low <= high ? [low, high] : undefined;
}

/** Returns the unit in which the heights have the usual magnitude of flank deviations. @param {FlankSurface | undefined} surface @returns {Unit} */
export function likelyUnit(surface) {
  const ends = surface && endsOf(surface.z);
  const units = /** @type {Unit[]} */ (Object.keys(MICROMETRES));
  const [least = 0, most = 0] = USUAL;
  const fits = (/** @type {Unit} */ unit) => {
    const span = ends ? (ends[1] - ends[0]) * MICROMETRES[unit] : 0;
    return span >= least && span <= most;
  };
  return units.find(fits) ?? "um";
}

/**
 * Returns the likely quantity of the first abscissa, in mm: no roll length is as great as the tip
 * radius.
 * @param {FlankSurface | undefined} surface @param {Gear | null | undefined} gear @returns {Along | undefined} none without a gear
 */
export function likelyAlong(surface, gear) {
  const ends = surface && endsOf(surface.u);
  if (!gear || !ends) return undefined;
  const reference = (gear.teeth * gear.normal_module_mm) / Math.cos(((gear.helix_angle_deg ?? 0) * Math.PI) / 180);
  return ends[0] > reference / 2 ? "diameter" : "roll_length";
}

/** Returns the flank named in the name of a file. @param {string} name @returns {"left" | "right" | ""} */
export function likelyFlank(name) {
  const says = (/** @type {string} */ words) => new RegExp(`(^|[^a-z])(${words})([^a-z]|$)`, "i").test(name);
  const [left, right] = [says("left|links|l"), says("right|rechts|r")];
  if (left === right) return "";
  return left ? "left" : "right";
}

/** Returns the greatest deviation in µm, and the ends of the first abscissa in mm. @param {FlankSurface | undefined} surface @param {Unit} unit */
export function inWords(surface, unit) {
  const [heights, along] = surface ? [endsOf(surface.z), endsOf(surface.u)] : [];
  if (!heights || !along) return undefined;
  return {
    greatest: Math.max(Math.abs(heights[0]), Math.abs(heights[1])) * MICROMETRES[unit],
    from: along[0],
    to: along[1],
  };
}
