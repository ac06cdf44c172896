// The range over which an estimate is drawn with its interval and bounds. Pure.

/** @typedef {number | null | undefined} Maybe */
/**
 * @typedef {object} Estimate
 * @property {Maybe} value
 * @property {Maybe} [error] standard error
 * @property {readonly number[] | null | undefined} [interval]
 * @property {Maybe} [intervalError] that of what the interval is of, where it is another: least squares
 * @property {Maybe} [bias] the most that the bias can be
 * @property {Maybe} [leastSquares]
 */

/** @param {Maybe} value @returns {value is number} */
export const finite = (value) => typeof value === "number" && Number.isFinite(value);

/** Returns all values drawn of an estimate. @param {Estimate} estimate */
function reach({ value, error, interval, bias, leastSquares }) {
  const about = (/** @type {Maybe} */ by) => (finite(value) && finite(by) ? [value - by, value + by] : []);
  return [value, leastSquares, ...(interval ?? []), ...about(error), ...about(bias)].filter(finite);
}

/**
 * Returns the range from the least to the greatest drawn value, and 0 if it is near.
 * @param {readonly Estimate[]} estimates @param {readonly (readonly number[] | null | undefined)[]} [limits]
 * @returns {[number, number]}
 */
export function stripDomain(estimates, limits = []) {
  const all = [...estimates.flatMap(reach), ...limits.flatMap((ends) => ends ?? []).filter(finite)];
  if (all.length === 0) return [-1, 1];
  let [low, high] = [Math.min(...all), Math.max(...all)];
  const size = high - low;
  if (low > 0 && low <= size) low = 0;
  else if (high < 0 && -high <= size) high = 0;
  if (low === high) return low === 0 ? [-1, 1] : [low - Math.abs(low) / 2, low + Math.abs(low) / 2];
  return [low, high];
}

/**
 * Converts a coefficient or a figure of the interface.
 * @param {{ value: number, std_error?: Maybe, interval?: readonly number[] | null, bias_bound?: Maybe, least_squares?: Maybe,
 *   least_squares_std_error?: Maybe }} of
 * @returns {Estimate}
 */
export const estimateOf = ({ value, std_error, interval, bias_bound, least_squares, least_squares_std_error }) => ({
  value,
  error: std_error,
  interval,
  intervalError: least_squares_std_error,
  bias: bias_bound,
  leastSquares: least_squares,
});
