// Suspected gross errors and excluded nodes. Pure.

/** @typedef {import("../api/client.js").Schema<"FitSpec">} FitSpec */
/** @typedef {import("../api/client.js").Schema<"NodeAt">} NodeAt */
/** @typedef {{ code: string, params?: Record<string, any> | null | undefined }} Warning */
/** @typedef {{ index: number, row?: number, column?: number, off: number, off_sigmas: number }} Suspect */
/** @typedef {{ index: number, kind: "suspected" | "excluded" }} NodeMark */

/** Returns the parameters of the fit's warning about suspected gross errors. @param {readonly Warning[]} warnings */
export const outliersOf = (warnings) => warnings.find(({ code }) => code === "outliers_suspected")?.params ?? undefined;

/** Returns the suspected nodes. @param {readonly Warning[]} warnings @returns {readonly Suspect[]} */
export const suspectsOf = (warnings) => outliersOf(warnings)?.["nodes"] ?? [];

/** Returns the index of a node in the order posted. @param {NodeAt} at @param {number | undefined} columns of a grid */
export const indexOf = (at, columns) => (typeof at === "number" ? at : at.row * (columns ?? 0) + at.column);

/** Describes a node for a request. @param {number} index @param {number | undefined} columns of a grid @returns {NodeAt} */
export const nodeAt = (index, columns) =>
  columns === undefined ? index : { row: Math.floor(index / columns), column: index % columns };

/** Returns the indices of the nodes that a fit excludes. @param {FitSpec} spec @param {number | undefined} columns */
export const excludedBy = (spec, columns) => (spec.exclude ?? []).map((at) => indexOf(at, columns));

/** Returns the spec with exactly these nodes excluded. @param {FitSpec} spec @param {readonly number[]} out indices of all excluded nodes @param {number | undefined} columns @returns {FitSpec} */
export function excluding(spec, out, columns) {
  const { exclude: _, ...rest } = spec;
  const sorted = [...new Set(out)].sort((a, b) => a - b);
  return sorted.length === 0 ? rest : { ...rest, exclude: sorted.map((index) => nodeAt(index, columns)) };
}

/** Returns the marks of nodes on a map. @param {readonly Warning[]} warnings @param {readonly number[]} excluded @returns {readonly NodeMark[]} */
export const marksOf = (warnings, excluded) => [
  ...suspectsOf(warnings).map(({ index }) => ({ index, kind: /** @type {const} */ ("suspected") })),
  ...excluded.map((index) => ({ index, kind: /** @type {const} */ ("excluded") })),
];
