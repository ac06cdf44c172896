// Scattered nodes as triangles (Delaunay), for which both axes count by shares of their ranges.

import { Delaunay } from "../../vendor/d3.js";

/**
 * @param {ArrayLike<number>} u @param {ArrayLike<number>} v @param {ArrayLike<number | null>} z
 * @returns {import("./surface.js").Scattered}
 */
export function scatteredOf(u, v, z) {
  const heights = Float64Array.from(z, (value) => value ?? Number.NaN);
  const [us, vs] = [Float64Array.from(u), Float64Array.from(v)];
  const there = Uint32Array.from(heights.keys()).filter((i) => Number.isFinite(heights[i]));
  const places = new Float64Array(2 * there.length);
  const [shareU, shareV] = [shares(us), shares(vs)];
  for (let k = 0; k < there.length; k += 1) {
    const i = there[k] ?? 0;
    places[2 * k] = shareU(us[i] ?? 0);
    places[2 * k + 1] = shareV(vs[i] ?? 0);
  }
  const triangles = there.length < 3 ? new Uint32Array() : new Delaunay(places).triangles;
  return { kind: "scattered", u: us, v: vs, z: heights, triangles: Uint32Array.from(triangles, (k) => there[k] ?? 0) };
}

/** @param {Float64Array} values */
function shares(values) {
  let [low, high] = [Number.POSITIVE_INFINITY, Number.NEGATIVE_INFINITY];
  for (const value of values) [low, high] = [Math.min(low, value), Math.max(high, value)];
  return (/** @type {number} */ value) => (high > low ? (value - low) / (high - low) : 0);
}
