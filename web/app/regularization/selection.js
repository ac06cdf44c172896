// The λ* (k, λ, rank) that is viewed: a criterion's, or a value. Pure functions.

/** @typedef {import("../api/client.js").Schema<"FitSpec">} FitSpec */
/** @typedef {import("../api/client.js").Schema<"FitResult">} FitResult */
/** @typedef {import("../api/client.js").Schema<"PreviewRequest">} PreviewRequest */
/** @typedef {{ by: string } | { value: number }} Selection */
/** @typedef {readonly [number, number]} Range */

const PARAMETERS = /** @type {Record<string, "lambda_star" | "parameter">} */ ({
  spectral: "lambda_star",
  ridge: "parameter",
  tikhonov: "parameter",
  attraction: "parameter",
});

/** Returns true if the regularisation has an adjustable number. @param {FitSpec} spec */
export function movable(spec) {
  const type = spec.regularization?.type ?? "";
  return type in PARAMETERS || type === "truncated_svd";
}

/** Returns true if that number is a count of directions. @param {FitSpec} spec */
export const countsRank = (spec) => spec.regularization?.type === "truncated_svd";

/** Returns the page's symbol for the server's number. @param {FitSpec} spec */
export function symbolOf(spec) {
  const type = spec.regularization?.type;
  if (type === "ridge" || type === "attraction") return "k";
  return type === "tikhonov" ? "λ" : "λ*";
}

/**
 * Returns a refit by this selection; the rest of the fit stays.
 * @param {FitSpec} spec @param {Selection} selection @param {readonly string[]} [include]
 * @returns {PreviewRequest}
 */
export function refitOf(spec, selection, include) {
  const whole = include ? { ...spec, include } : spec;
  return /** @type {PreviewRequest} */ ({ ...whole, regularization: regularizationOf(spec, selection) });
}

/** @param {FitSpec} spec @param {Selection} selection */
function regularizationOf(spec, selection) {
  const base = /** @type {Record<string, unknown>} */ (spec.regularization ?? { type: "spectral" });
  if ("by" in selection && selection.by === "least_squares") return { type: "none" };
  if (countsRank(spec)) {
    const { rank: _, parameter: __, ...rest } = base;
    if ("value" in selection) return { ...rest, rank: Math.round(selection.value) };
    return { ...rest, parameter: { criterion: selection.by } };
  }
  const name = PARAMETERS[String(base["type"])] ?? "lambda_star";
  const own = /** @type {{ criterion?: string } | undefined} */ (base[name]);
  if ("value" in selection) return { ...base, [name]: { criterion: "fixed", value: selection.value } };
  return { ...base, [name]: own?.criterion === selection.by ? own : { criterion: selection.by } };
}

/** Returns the range of the slider: [λ₁, λₙ], or the ranks. @param {FitSpec} spec @param {FitResult} result @returns {Range | undefined} */
export function rangeOf(spec, result) {
  const eigenvalues = result.spectrum.eigenvalues;
  if (countsRank(spec)) return [1, Math.max(1, result.spectrum.rank)];
  const curve = result.lambda_curve;
  const [low, high] = [curve?.[0]?.lambda_star ?? eigenvalues[0], curve?.at(-1)?.lambda_star ?? eigenvalues.at(-1)];
  return low !== undefined && high !== undefined && low > 0 && high > low ? [low, high] : undefined;
}

/** Returns the value at a share of the slider's range, in ln λ*. @param {Range} range @param {number} part 0…1 */
export function valueAt([low, high], part) {
  if (part <= 0) return low;
  return part >= 1 ? high : Number((low * (high / low) ** part).toPrecision(6));
}

/** @param {Range} range @param {number | null | undefined} value */
export function partOf([low, high], value) {
  if (!value || value <= low) return 0;
  return Math.min(1, Math.log(value / low) / Math.log(high / low));
}

/** Reads the address: `by=gcv` or `lambda=1e-5`. @param {URLSearchParams} query @returns {Selection | undefined} */
export function selectionOf(query) {
  const by = query.get("by");
  if (by) return { by };
  const value = Number(query.get("lambda") ?? Number.NaN);
  return value > 0 && Number.isFinite(value) ? { value } : undefined;
}

/** @param {Selection | undefined} selection */
export function queryOf(selection) {
  return {
    by: selection && "by" in selection ? selection.by : undefined,
    lambda: selection && "value" in selection ? selection.value : undefined,
  };
}
