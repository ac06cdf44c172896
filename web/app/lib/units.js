// Units of an iteration's axes.

/** @typedef {import("../api/client.js").Schema<"Axes">} Axes */

const SIGNS = /** @type {Record<string, string>} */ ({ um: "µm", mm: "mm", deg: "°", arcmin: "′", rad: "rad" });

/** How a unit is written, which is data; none where nothing was said of it. @param {string | null | undefined} unit */
export function unitSign(unit) {
  return unit ? (SIGNS[unit] ?? unit) : undefined;
}

/** The unit of the heights. @param {Axes | null | undefined} axes */
export function heightUnit(axes) {
  return unitSign(axes?.z?.unit ?? axes?.y?.unit);
}
