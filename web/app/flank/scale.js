// The automatic scale of a surface, computed once, and a common scale for several.

import { symmetricLimit } from "../lib/colour.js";

/** @typedef {import("./surface.js").FlankSurface} FlankSurface */

/** @type {WeakMap<Float64Array, ReturnType<typeof symmetricLimit>>} */
const known = new WeakMap();

/** @param {FlankSurface} surface */
export function scaleFor({ z }) {
  const scale = known.get(z) ?? symmetricLimit(z);
  known.set(z, scale);
  return scale;
}

/** Returns a common scale for several surfaces. @param {readonly FlankSurface[]} surfaces */
export function commonScale(surfaces) {
  const limit = surfaces.reduce((most, surface) => Math.max(most, scaleFor(surface).limit), 0) || 1;
  return { limit, clipped: surfaces.reduce((sum, surface) => sum + clippedBy(surface, limit), 0) };
}

/** Returns the number of heights outside a limit. @param {FlankSurface} surface @param {number} limit */
export function clippedBy(surface, limit) {
  const own = scaleFor(surface);
  if (limit === own.limit) return own.clipped;
  let count = 0;
  for (const z of surface.z) if (Math.abs(z) > limit) count += 1;
  return count;
}
