// The scale that suits a surface, found once.

import { symmetricLimit } from "../lib/colour.js";

/** @type {WeakMap<Float64Array, ReturnType<typeof symmetricLimit>>} */
const known = new WeakMap();

/** @param {import("./surface.js").FlankSurface} surface */
export function scaleFor({ z }) {
  const scale = known.get(z) ?? symmetricLimit(z);
  known.set(z, scale);
  return scale;
}
