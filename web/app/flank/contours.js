// Contour lines of heights on a lattice, by marching squares. Pure.

/** @typedef {{ level: number, segments: [number, number, number, number][] }} Contour ends of each piece: x, y, x, y */

/**
 * Returns lines of equal height over a lattice of places.
 * @param {ArrayLike<number>} heights row by row; what is not finite is left out @param {number} width columns
 * @param {readonly number[]} levels
 * @returns {Contour[]} in columns and rows from 0
 */
export function contoursOf(heights, width, levels) {
  const rows = Math.floor(heights.length / width);
  const found = levels.map((level) => ({ level, segments: /** @type {Contour["segments"]} */ ([]) }));
  for (let y = 0; y + 1 < rows; y += 1) {
    for (let x = 0; x + 1 < width; x += 1) {
      const k = y * width + x;
      const [a, b] = [heights[k] ?? Number.NaN, heights[k + 1] ?? Number.NaN];
      const [d, c] = [heights[k + width] ?? Number.NaN, heights[k + width + 1] ?? Number.NaN];
      if (!Number.isFinite(a + b + c + d)) continue;
      const [low, high] = [Math.min(a, b, c, d), Math.max(a, b, c, d)];
      for (const contour of found) {
        if (contour.level > low && contour.level <= high) through(contour, x, y, [a, b, c, d]);
      }
    }
  }
  return found.filter(({ segments }) => segments.length > 0);
}

/** @param {Contour} contour @param {number} x @param {number} y @param {readonly [number, number, number, number]} corners clockwise from above left */
function through({ level, segments }, x, y, [a, b, c, d]) {
  /** @type {[number, number][]} */
  const ends = [];
  const share = (/** @type {number} */ from, /** @type {number} */ to) => (level - from) / (to - from);
  if (a < level !== b < level) ends.push([x + share(a, b), y]);
  if (b < level !== c < level) ends.push([x + 1, y + share(b, c)]);
  if (c < level !== d < level) ends.push([x + 1 - share(c, d), y + 1]);
  if (d < level !== a < level) ends.push([x, y + 1 - share(d, a)]);
  const [p, q, r, s] = ends;
  if (!p || !q) return;
  if (!r || !s) {
    segments.push([...p, ...q]);
    return;
  }
  // a saddle: the mean decides which corners are connected
  const together = (a + b + c + d) / 4 < level === a < level;
  if (together) segments.push([...p, ...q], [...r, ...s]);
  else segments.push([...s, ...p], [...q, ...r]);
}

/** Contour intervals for the steps of automatic scales: four to six lines on each side of 0. @type {Record<number, number>} */
const DISTANCE = { 1: 0.2, 1.5: 0.3, 2: 0.5, 3: 0.5, 4: 1, 5: 1, 6: 1, 8: 2 };

/** The contour interval of a symmetric scale. @param {number} limit */
function distanceOf(limit) {
  const power = 10 ** Math.floor(Math.log10(limit) + 1e-9);
  const step = DISTANCE[Number((limit / power).toPrecision(6))];
  return step === undefined ? limit / 5 : Number((step * power).toPrecision(6));
}

/** Contour levels of a symmetric scale: the same on each side of 0, and 0. @param {number} limit */
export function levelsOf(limit) {
  const distance = distanceOf(limit);
  const steps = Math.floor(limit / distance + 1e-9);
  return Array.from({ length: 2 * steps + 1 }, (_, i) => Number(((i - steps) * distance).toPrecision(12)));
}
