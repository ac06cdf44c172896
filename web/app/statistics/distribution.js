// The distribution of residuals. Pure functions.

/** @typedef {import("../api/client.js").Schema<"Nodes">} Nodes */

/** The maximum number of points of a chart. */
export const MOST_POINTS = 2000;

/**
 * Returns bins of equal width (Freedman and Diaconis), from 5 to 60.
 * @param {readonly number[]} values
 */
export function histogram(values) {
  const sorted = [...values].sort((a, b) => a - b);
  const [low, high] = [sorted[0], sorted.at(-1)];
  if (low === undefined || high === undefined) return [];
  if (low === high) return [{ from: low - 0.5, to: low + 0.5, count: sorted.length }];
  const quartile = (/** @type {number} */ part) => sorted[Math.floor(part * (sorted.length - 1))] ?? 0;
  const width = (2 * (quartile(0.75) - quartile(0.25))) / Math.cbrt(sorted.length);
  const bins = Math.min(60, Math.max(5, width > 0 ? Math.ceil((high - low) / width) : 5));
  const step = (high - low) / bins;
  const counts = new Array(bins).fill(0);
  for (const value of sorted) counts[Math.min(bins - 1, Math.floor((value - low) / step))] += 1;
  return counts.map((count, i) => ({ from: low + i * step, to: low + (i + 1) * step, count }));
}

/** Samples a list evenly, the first and the last included. @template T @param {readonly T[]} list @returns {readonly T[]} */
export function thinned(list) {
  if (list.length <= MOST_POINTS) return list;
  const step = (list.length - 1) / (MOST_POINTS - 1);
  return Array.from({ length: MOST_POINTS }, (_, i) => /** @type {T} */ (list[Math.round(i * step)]));
}

/** Returns sorted values against normal quantiles at (i − ½)/n. @param {readonly number[]} values */
export function quantiles(values) {
  const sorted = [...values].sort((a, b) => a - b);
  return sorted.map((y, i) => ({ x: normalQuantile((i + 0.5) / sorted.length), y }));
}

/** Returns the standard normal quantile (Acklam), to 1.2·10⁻⁹ relative. @param {number} p @returns {number} */
export function normalQuantile(p) {
  if (p > 0.5) return -normalQuantile(1 - p);
  if (p < 0.02425) {
    const q = Math.sqrt(-2 * Math.log(p));
    return (
      (((((-7.784894002430293e-3 * q - 0.3223964580411365) * q - 2.400758277161838) * q - 2.549732539343734) * q +
        4.374664141464968) *
        q +
        2.938163982698783) /
      ((((7.784695709041462e-3 * q + 0.3224671290700398) * q + 2.445134137142996) * q + 3.754408661907416) * q + 1)
    );
  }
  const q = p - 0.5;
  const r = q * q;
  return (
    ((((((-39.69683028665376 * r + 220.9460984245205) * r - 275.9285104469687) * r + 138.357751867269) * r -
      30.66479806614716) *
      r +
      2.506628277459239) *
      q) /
    (((((-54.47609879822406 * r + 161.5858368580409) * r - 155.6989798598866) * r + 66.80131188771972) * r -
      13.28068155288572) *
      r +
      1)
  );
}

/**
 * Returns the place of a posted node, by its index (grids row by row): u and v, or x.
 * @param {Nodes} nodes @param {number} index @returns {Record<string, number | undefined>}
 */
export function placeOfNode(nodes, index) {
  if (nodes.type === "grid") {
    return { u: nodes.u[Math.floor(index / nodes.v.length)], v: nodes.v[index % nodes.v.length] };
  }
  if (nodes.type === "scattered") return { u: nodes.u[index], v: nodes.v[index] };
  return nodes.type === "curve" ? { x: nodes.x[index] } : {};
}
