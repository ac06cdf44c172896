// Colours of values and of series.

import { batlow, vik } from "./colour_maps.js";

/** @typedef {import("./colour_maps.js").Rgb} Rgb */

/**
 * Series (Okabe and Ito), as names of tokens, so that they suit light and dark.
 * Colour is never alone: left flanks are solid, right ones dashed.
 */
export const SERIES = /** @type {const} */ (["blue", "vermilion", "green", "purple", "orange", "sky", "yellow", "ink"]);

/** The tokens of `SERIES` by name. */
export const OKABE_ITO = {
  blue: [0, 114, 178],
  vermilion: [213, 94, 0],
  green: [0, 158, 115],
  purple: [204, 121, 167],
  orange: [230, 159, 0],
  sky: [86, 180, 233],
  yellow: [240, 228, 66],
  ink: [0, 0, 0],
};

/** Line dashes of a flank. @param {"left" | "right" | undefined} flank */
export function dashOf(flank) {
  return flank === "right" ? "6 4" : undefined;
}

/**
 * Returns the step of a colour map at a share of its range, which is clamped to 0…1.
 * @param {readonly Rgb[]} map @param {number} share @returns {Rgb}
 */
function stepAt(map, share) {
  const index = Math.round(Math.min(1, Math.max(0, share)) * (map.length - 1));
  return map[index] ?? [128, 128, 128];
}

/** Returns the colour of a deviation on a scale from -limit to limit. @param {number} value @param {number} limit */
export function deviationColour(value, limit) {
  return stepAt(vik, limit > 0 ? 0.5 + value / (2 * limit) : 0.5);
}

/** Returns the colour of an amount between the least and the greatest. @param {number} value @param {readonly [number, number]} range */
export function amountColour(value, [low, high]) {
  return stepAt(batlow, high > low ? (value - low) / (high - low) : 0);
}

/** Formats a colour for CSS. @param {Rgb} colour */
export function css([red, green, blue]) {
  return `rgb(${red} ${green} ${blue})`;
}

/** The factor by which the greatest height must exceed the 99 % quantile for a scale to clip heights above it. */
const FAR = 2;

/**
 * Returns the limit of a symmetric scale, and the number of values it clips. The limit is the next
 * step above the greatest magnitude, so that nothing is clipped, unless at most 1 % of the values
 * lie far above the others.
 * @param {Iterable<number | null>} values
 * @returns {{ limit: number, clipped: number }}
 */
export function symmetricLimit(values) {
  const sizes = magnitudes(values);
  const whole = niceAbove(greatestOf(sizes));
  const most = niceAbove(atRank(sizes, Math.ceil(0.99 * sizes.length) - 1));
  const limit = whole > FAR * most ? most : whole;
  let clipped = 0;
  for (let i = 0; i < sizes.length; i += 1) if (/** @type {number} */ (sizes[i]) > limit) clipped += 1;
  return { limit, clipped };
}

/** @param {Float64Array} sizes */
function greatestOf(sizes) {
  let greatest = 0;
  for (let i = 0; i < sizes.length; i += 1) greatest = Math.max(greatest, /** @type {number} */ (sizes[i]));
  return greatest;
}

/** @param {Iterable<number | null>} values */
function magnitudes(values) {
  const all = values instanceof Float64Array ? values : Array.isArray(values) ? values : [...values];
  const sizes = new Float64Array(all.length);
  let count = 0;
  for (let i = 0; i < all.length; i += 1) {
    const value = all[i];
    if (typeof value === "number" && Number.isFinite(value)) {
      sizes[count] = Math.abs(value);
      count += 1;
    }
  }
  return sizes.subarray(0, count);
}

const BINS = 4096;

/**
 * Returns the size that has `rank` others before it in order. Only its bin is sorted, so that a map
 * of 100,000 nodes does not block the page.
 * @param {Float64Array} sizes none below 0 @param {number} rank
 */
function atRank(sizes, rank) {
  if (sizes.length === 0) return 0;
  const greatest = greatestOf(sizes);
  const bin = (/** @type {number} */ size) => (greatest > 0 ? Math.floor((size / greatest) * (BINS - 1)) : 0);
  const counts = new Uint32Array(BINS);
  for (let i = 0; i < sizes.length; i += 1) {
    const at = bin(/** @type {number} */ (sizes[i]));
    counts[at] = /** @type {number} */ (counts[at]) + 1;
  }
  let [at, before] = [0, 0];
  while (before + /** @type {number} */ (counts[at]) <= rank) {
    before += /** @type {number} */ (counts[at]);
    at += 1;
  }
  return sizes.filter((size) => bin(size) === at).sort()[rank - before] ?? 0;
}

/** Steps of a scale within a decade. */
const STEPS = [1, 1.5, 2, 3, 4, 5, 6, 8, 10];

/** Returns all steps from `low` to `high`. @param {number} low @param {number} high */
export function stepsBetween(low, high) {
  const steps = [];
  for (let step = niceAbove(low); step <= high; step = niceAbove(step * 1.01)) steps.push(step);
  return steps;
}

/** Returns the least step times a power of ten that is not below a value. @param {number} value */
export function niceAbove(value) {
  if (!(value > 0)) return 1;
  const power = 10 ** Math.floor(Math.log10(value));
  const factor = STEPS.find((step) => step * power >= value * (1 - 1e-12)) ?? 10;
  return Number((factor * power).toPrecision(2));
}
