// A small picture of a flank from its figures: the surface of second order that has them. Pure.

import { deviationColour, niceAbove } from "./colour.js";

/** @typedef {import("../api/client.js").Schema<"ShortFigures">} ShortFigures */
/** @typedef {import("../api/client.js").Schema<"FlankSide">} FlankSide */
/** @typedef {{ figures?: ShortFigures | undefined, flank?: FlankSide | undefined }} Flank `flank`: left if it is unknown */

export const [COLUMNS, ROWS] = [24, 12];

/**
 * Returns the material at a place of the flank, µm. `u` runs from −1 at the root to 1 at the tip,
 * `v` from −1 at face I to 1 at face II. A helix that deviates to the right hand has more material
 * at face II on left flanks, and less on right ones.
 * @param {Flank} of @param {number} u @param {number} v
 */
export function materialAt({ figures = {}, flank }, u, v) {
  const of = (/** @type {"profile_slope" | "helix_slope" | "profile_crowning" | "helix_crowning" | "twist"} */ name) =>
    figures[/** @type {const} */ (`${name}_um`)] ?? 0;
  const along = flank === "right" ? -v : v;
  const slopes = (of("profile_slope") * u + of("helix_slope") * along) / 2;
  const crownings = of("profile_crowning") * (1 - u * u) + of("helix_crowning") * (1 - v * v);
  return slopes + crownings + (of("twist") * u * along) / 4 - (2 / 3) * (of("profile_crowning") + of("helix_crowning"));
}

/** Returns all heights, rows from the tip down, face I left. @param {Flank} flank */
export function heightsOf(flank) {
  const centre = (/** @type {number} */ i, /** @type {number} */ n) => (2 * (i + 0.5)) / n - 1;
  return Array.from({ length: ROWS * COLUMNS }, (_, i) =>
    materialAt(flank, -centre(Math.floor(i / COLUMNS), ROWS), centre(i % COLUMNS, COLUMNS)),
  );
}

/** Returns one scale for several flanks: ± the greatest height. @param {readonly Flank[]} all */
export function commonLimit(all) {
  return niceAbove(
    Math.max(0, ...all.flatMap((flank) => (flank.figures ? heightsOf(flank).map((one) => Math.abs(one)) : []))),
  );
}

/** Returns its pixels, for a canvas. @param {Flank} flank @param {number} limit */
export function pixelsOf(flank, limit) {
  const pixels = new Uint8ClampedArray(4 * ROWS * COLUMNS);
  for (const [i, height] of heightsOf(flank).entries()) pixels.set([...deviationColour(height, limit), 255], 4 * i);
  return pixels;
}
