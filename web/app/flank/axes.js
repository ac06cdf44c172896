// Names of the axes of a flank.

import { t } from "../i18n/flank.js";
import { unitSign } from "../lib/units.js";

/** @typedef {import("../api/client.js").Schema<"Axes">} Axes */

/** Returns the names of the axes of a map. @param {Axes | null | undefined} axes @returns {import("./heat_map.js").MapAxes} */
export function mapAxes(axes) {
  return { u: axisOf(axes?.u, "u"), v: axisOf(axes?.v, "v") };
}

/** @param {import("../api/client.js").Schema<"Axis"> | null | undefined} axis @param {string} name */
export function axisOf(axis, name) {
  if (!axis) return { label: name };
  const known = /** @type {Record<string, string>} */ ({
    roll_length: axis.unit === "deg" ? t.roll_angle : t.roll_length,
    diameter: t.diameter,
    face_width: t.face_width,
    deviation: t.deviation,
  });
  return { label: known[axis.quantity] ?? axis.quantity, unit: unitSign(axis.unit) };
}
