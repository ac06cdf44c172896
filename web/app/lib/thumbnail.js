// A flank as its figures make it, small: the surface of second order that has them. Pure.

import { deviationColour, niceAbove } from "./colour.js";

/** @typedef {import("../api/client.js").Schema<"ShortFigures">} ShortFigures */

export const [COLUMNS, ROWS] = [24, 12];

/**
 * Material at a place of the flank, µm. `u` runs from −1 at the root to 1 at the tip, `v` from −1 to 1 to that end of the
 * width where a helix that deviates towards the right hand has more material.
 * @param {ShortFigures} figures @param {number} u @param {number} v
 */
export function materialAt(figures, u, v) {
  const of = (/** @type {"profile_slope" | "helix_slope" | "profile_crowning" | "helix_crowning" | "twist"} */ name) =>
    figures[/** @type {const} */ (`${name}_um`)] ?? 0;
  const slopes = (of("profile_slope") * u + of("helix_slope") * v) / 2;
  const crownings = of("profile_crowning") * (1 - u * u) + of("helix_crowning") * (1 - v * v);
  return slopes + crownings + (of("twist") * u * v) / 4 - (2 / 3) * (of("profile_crowning") + of("helix_crowning"));
}

/** All heights, rows from the tip down. @param {ShortFigures} figures */
export function heightsOf(figures) {
  const centre = (/** @type {number} */ i, /** @type {number} */ n) => (2 * (i + 0.5)) / n - 1;
  return Array.from({ length: ROWS * COLUMNS }, (_, i) =>
    materialAt(figures, -centre(Math.floor(i / COLUMNS), ROWS), centre(i % COLUMNS, COLUMNS)),
  );
}

/** One scale for several flanks: ± what holds all of them. @param {readonly (ShortFigures | undefined)[]} all */
export function commonLimit(all) {
  return niceAbove(
    Math.max(0, ...all.flatMap((figures) => (figures ? heightsOf(figures).map((one) => Math.abs(one)) : []))),
  );
}

/** Its pixels, as a canvas takes them. @param {ShortFigures} figures @param {number} limit */
export function pixelsOf(figures, limit) {
  const pixels = new Uint8ClampedArray(4 * ROWS * COLUMNS);
  for (const [i, height] of heightsOf(figures).entries()) pixels.set([...deviationColour(height, limit), 255], 4 * i);
  return pixels;
}
