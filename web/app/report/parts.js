// The parts of a report, and their form in the address. Pure.

export const PARTS = /** @type {const} */ ([
  "summary",
  "maps",
  "evaluation",
  "pitch",
  "lambda",
  "spectrum",
  "correction",
  "trace",
  "warnings",
  "provenance",
]);
/** @typedef {(typeof PARTS)[number]} Part */

/**
 * Returns the iterations of a report: the existing ones that the address names, in their order; by
 * default the first and the last.
 * @param {string | null} text such as `1,2` @param {readonly number[]} there
 */
export function iterationsOf(text, there) {
  const wanted = new Set((text ?? "").split(",").filter(Boolean).map(Number));
  const found = there.filter((number) => wanted.has(number));
  if (found.length > 0) return found;
  return there.filter((_, i) => i === 0 || i === there.length - 1);
}

/** Returns the parts of a report; by default all. @param {string | null} text such as `summary,maps` @returns {readonly Part[]} */
export function partsOf(text) {
  const wanted = new Set((text ?? "").split(","));
  const found = PARTS.filter((part) => wanted.has(part));
  return found.length > 0 ? found : PARTS;
}

/**
 * Returns the form of a choice in the address; undefined for the default.
 * @template Value
 * @param {readonly Value[]} chosen @param {readonly Value[]} byDefault
 */
export function written(chosen, byDefault) {
  const same = chosen.length === byDefault.length && chosen.every((one, i) => one === byDefault[i]);
  return same ? undefined : chosen.join(",");
}
