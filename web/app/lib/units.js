// Units of an iteration's axes.

/** @typedef {import("../api/client.js").Schema<"Axes">} Axes */

const SIGNS = /** @type {Record<string, string>} */ ({ um: "µm", mm: "mm", deg: "°", arcmin: "′", rad: "rad" });

/** Returns a unit as it is written, which is data; undefined if none was given. @param {string | null | undefined} unit */
export function unitSign(unit) {
  return unit ? (SIGNS[unit] ?? unit) : undefined;
}

/** @typedef {"um" | "mm" | "nm" | "in"} Unit */

/** Micrometres in a unit of length; the most common units of testers come first. */
export const MICROMETRES =
  /** @type {Readonly<Record<Unit, number>> & Readonly<Record<string, number | undefined>>} */ ({
    um: 1,
    mm: 1000,
    nm: 0.001,
    in: 25_400,
  });

/** Returns the factor from heights to µm of excess material; undefined for a unit of the caller's own. @param {Axes | null | undefined} axes */
export function micrometres(axes) {
  const height = axes?.z ?? axes?.y;
  const factor = MICROMETRES[height?.unit ?? ""];
  return factor !== undefined && height?.positive === "material_in" ? -factor : factor;
}

/** The unit of the heights. @param {Axes | null | undefined} axes */
export function heightUnit(axes) {
  return unitSign(axes?.z?.unit ?? axes?.y?.unit);
}
