// A flank as nodes: on a grid or scattered, with its sections. Pure functions; missing heights are NaN.
// u runs from root to tip, v along the face width.

/** @typedef {{ kind: "grid", u: Float64Array, v: Float64Array, z: Float64Array }} Grid `z` row by row: all v of the first u first */
/** @typedef {{ kind: "scattered", u: Float64Array, v: Float64Array, z: Float64Array, triangles: Uint32Array }} Scattered */
/** @typedef {Grid | Scattered} FlankSurface */
/** @typedef {readonly [number, number]} Range */
/** @typedef {{ u: Range, v: Range }} Box */
/** @typedef {{ index: number, u: number, v: number, z: number, row?: number, column?: number }} FlankNode `row`, `column` from 0 */
/** @typedef {{ x: number, y: number }} SectionPoint `y` is NaN in a gap */

/**
 * @param {ArrayLike<number>} u @param {ArrayLike<number>} v
 * @param {ArrayLike<ArrayLike<number | null>>} rows one for each u
 * @param {ArrayLike<ArrayLike<boolean>> | null} [valid] false: missing
 * @returns {Grid}
 */
export function gridOf(u, v, rows, valid) {
  const z = new Float64Array(u.length * v.length).fill(Number.NaN);
  for (let i = 0; i < u.length; i += 1) {
    for (let j = 0; j < v.length; j += 1) {
      const value = rows[i]?.[j];
      if (typeof value === "number" && valid?.[i]?.[j] !== false) z[i * v.length + j] = value;
    }
  }
  return { kind: "grid", u: Float64Array.from(u), v: Float64Array.from(v), z };
}

/** Returns the same nodes with other heights. @template {FlankSurface} S @param {S} surface @param {Float64Array} z @returns {S} */
export function withHeights(surface, z) {
  return { ...surface, z };
}

/** Returns the surface minus the mean of its heights. @template {FlankSurface} S @param {S} surface @returns {S} */
export function withoutMean(surface) {
  let [sum, count] = [0, 0];
  for (const z of surface.z) {
    if (Number.isNaN(z)) continue;
    sum += z;
    count += 1;
  }
  return count === 0
    ? surface
    : withHeights(
        surface,
        surface.z.map((z) => z - sum / count),
      );
}

/** @param {FlankSurface} surface @returns {Box} */
export function boxOf({ u, v }) {
  return { u: rangeOf(u), v: rangeOf(v) };
}

/** @param {Float64Array} values @returns {Range} */
function rangeOf(values) {
  let [low, high] = [Number.POSITIVE_INFINITY, Number.NEGATIVE_INFINITY];
  for (const value of values) {
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return low <= high ? [low, high] : [0, 1];
}

/** @param {FlankSurface} surface @param {number} index @returns {FlankNode} */
export function nodeOf(surface, index) {
  const z = surface.z[index] ?? Number.NaN;
  if (surface.kind === "scattered") return { index, u: at(surface.u, index), v: at(surface.v, index), z };
  const [row, column] = [Math.floor(index / surface.v.length), index % surface.v.length];
  return { index, u: at(surface.u, row), v: at(surface.v, column), z, row, column };
}

/** @param {Float64Array} values @param {number} index */
const at = (values, index) => values[index] ?? Number.NaN;

/** Counts the heights and the missing ones. @param {FlankSurface} surface */
export function countsOf({ z }) {
  let missing = 0;
  for (const value of z) if (Number.isNaN(value)) missing += 1;
  return { nodes: z.length, missing };
}

/** Results, each computed once. @type {WeakMap<FlankSurface, { least: FlankNode, greatest: FlankNode }>} */
const extremes = new WeakMap();

/** Returns the nodes with the least and the greatest height; undefined if all are missing. @param {FlankSurface} surface */
export function extremesOf(surface) {
  const kept = extremes.get(surface);
  if (kept) return kept;
  let [least, greatest] = [-1, -1];
  const { z } = surface;
  for (let i = 0; i < z.length; i += 1) {
    const value = at(z, i);
    if (Number.isNaN(value)) continue;
    if (least < 0 || value < at(z, least)) least = i;
    if (greatest < 0 || value > at(z, greatest)) greatest = i;
  }
  if (least < 0) return undefined;
  const found = { least: nodeOf(surface, least), greatest: nodeOf(surface, greatest) };
  extremes.set(surface, found);
  return found;
}

/** Returns the node nearest to a place, by shares of the box. @param {FlankSurface} surface @param {number} u @param {number} v */
export function nearestNode(surface, u, v) {
  if (surface.kind === "grid") {
    return nodeOf(surface, nearestIn(surface.u, u) * surface.v.length + nearestIn(surface.v, v));
  }
  const box = boxOf(surface);
  const [wide, high] = [box.v[1] - box.v[0] || 1, box.u[1] - box.u[0] || 1];
  let [best, least] = [0, Number.POSITIVE_INFINITY];
  for (let i = 0; i < surface.z.length; i += 1) {
    const distance = ((at(surface.u, i) - u) / high) ** 2 + ((at(surface.v, i) - v) / wide) ** 2;
    if (distance < least) [best, least] = [i, distance];
  }
  return nodeOf(surface, best);
}

/** @param {Float64Array} values ascending @param {number} value */
function nearestIn(values, value) {
  const i = below(values, value);
  return i + 1 < values.length && at(values, i + 1) - value < value - at(values, i) ? i + 1 : i;
}

/** Returns the last index whose value is no greater, at most the last but one. @param {Float64Array} values ascending @param {number} value */
export function below(values, value) {
  let [low, high] = [0, Math.max(0, values.length - 2)];
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (at(values, middle) <= value) low = middle;
    else high = middle - 1;
  }
  return low;
}

/**
 * Returns the height between the nodes: bilinear on a grid (linear if one corner of a cell is
 * missing), linear in triangles. NaN outside and at missing nodes.
 * @param {FlankSurface} surface @param {number} u @param {number} v
 */
export function heightAt(surface, u, v) {
  if (surface.kind === "scattered") return inTriangles(surface, u, v);
  const [i, s] = place(surface.u, u);
  const [j, t] = place(surface.v, v);
  if (i < 0 || j < 0) return Number.NaN;
  const next = surface.v.length > 1 ? 1 : 0;
  const row = surface.u.length > 1 ? surface.v.length : 0;
  const k = i * surface.v.length + j;
  const { z } = surface;
  return inCell(at(z, k), at(z, k + next), at(z, k + row), at(z, k + row + next), s, t);
}

/** Returns the cell of a value and the share within; -1 outside. @param {Float64Array} values @param {number} value @returns {[number, number]} */
export function place(values, value) {
  const last = values.length - 1;
  if (!(value >= at(values, 0) && value <= at(values, last))) return [-1, 0];
  if (last === 0) return [0, 0];
  const i = below(values, value);
  return [i, (value - at(values, i)) / (at(values, i + 1) - at(values, i))];
}

/**
 * Interpolates between four corners; s along u, t along v.
 * @param {number} a at s = t = 0 @param {number} b at t = 1 @param {number} c at s = 1 @param {number} d at both
 * @param {number} s @param {number} t
 */
export function inCell(a, b, c, d, s, t) {
  const value = (1 - s) * ((1 - t) * a + t * b) + s * ((1 - t) * c + t * d);
  if (!Number.isNaN(value)) return value;
  // on a node or an edge the other corners do not count
  if (s === 0) return t === 0 ? a : t === 1 ? b : (1 - t) * a + t * b;
  if (s === 1) return t === 0 ? c : t === 1 ? d : (1 - t) * c + t * d;
  if (t === 0) return (1 - s) * a + s * c;
  if (t === 1) return (1 - s) * b + s * d;
  // one missing corner: the triangle of the other three
  if (Number.isNaN(a)) return s + t >= 1 ? d + (1 - s) * (b - d) + (1 - t) * (c - d) : Number.NaN;
  if (Number.isNaN(d)) return s + t <= 1 ? a + s * (c - a) + t * (b - a) : Number.NaN;
  if (Number.isNaN(b)) return s >= t ? c + (1 - s) * (a - c) + t * (d - c) : Number.NaN;
  return t >= s ? b + s * (d - b) + (1 - t) * (a - b) : Number.NaN;
}

/** @param {Scattered} surface @param {number} u @param {number} v */
function inTriangles({ u: us, v: vs, z, triangles }, u, v) {
  for (let k = 0; k + 2 < triangles.length; k += 3) {
    const [a, b, c] = [triangles[k] ?? 0, triangles[k + 1] ?? 0, triangles[k + 2] ?? 0];
    const [ua, va] = [at(us, a), at(vs, a)];
    const [ub, vb] = [at(us, b) - ua, at(vs, b) - va];
    const [uc, vc] = [at(us, c) - ua, at(vs, c) - va];
    const area = ub * vc - uc * vb;
    if (area === 0) continue;
    const s = ((u - ua) * vc - (v - va) * uc) / area;
    const t = ((v - va) * ub - (u - ua) * vb) / area;
    if (s >= -1e-12 && t >= -1e-12 && s + t <= 1 + 1e-12) return (1 - s - t) * at(z, a) + s * at(z, b) + t * at(z, c);
  }
  return Number.NaN;
}

/**
 * Returns the section at one v (a profile, over u) or at one u (a helix, over v): through nodes if
 * it meets them, else between them.
 * @param {FlankSurface} surface @param {"profile" | "helix"} kind @param {number} place
 * @returns {SectionPoint[]}
 */
export function sectionOf(surface, kind, place) {
  if (surface.kind === "grid") {
    const along = kind === "profile" ? surface.u : surface.v;
    return Array.from(along, (x) => ({
      x,
      y: kind === "profile" ? heightAt(surface, x, place) : heightAt(surface, place, x),
    }));
  }
  return throughTriangles(surface, kind, place);
}

/** @param {Scattered} surface @param {"profile" | "helix"} kind @param {number} place */
function throughTriangles({ u, v, z, triangles }, kind, place) {
  const [along, across] = kind === "profile" ? [u, v] : [v, u];
  /** @type {Map<number, SectionPoint>} */
  const found = new Map();
  const edge = (/** @type {number} */ a, /** @type {number} */ b) => {
    const [from, to] = [at(across, a), at(across, b)];
    if (from > place === to > place || from === to) return;
    const share = (place - from) / (to - from);
    const x = at(along, a) + share * (at(along, b) - at(along, a));
    found.set(Math.min(a, b) * z.length + Math.max(a, b), { x, y: at(z, a) + share * (at(z, b) - at(z, a)) });
  };
  for (let k = 0; k + 2 < triangles.length; k += 3) {
    const [a, b, c] = [triangles[k] ?? 0, triangles[k + 1] ?? 0, triangles[k + 2] ?? 0];
    edge(a, b);
    edge(b, c);
    edge(c, a);
  }
  return [...found.values()].sort((one, other) => one.x - other.x);
}

/**
 * Returns the first minus the second, at the nodes of the first. The second's own height is used at
 * common nodes; otherwise it is interpolated, and `exact` is false.
 * @param {FlankSurface} first @param {FlankSurface} second
 */
export function difference(first, second) {
  const z = new Float64Array(first.z.length).fill(Number.NaN);
  const same = sameNodes(first, second);
  for (let i = 0; i < z.length; i += 1) {
    if (same) z[i] = at(first.z, i) - at(second.z, i);
    else {
      const node = nodeOf(first, i);
      z[i] = node.z - heightAt(second, node.u, node.v);
    }
  }
  return { surface: withHeights(first, z), exact: same };
}

/** @param {FlankSurface} first @param {FlankSurface} second */
function sameNodes(first, second) {
  if (first.kind !== second.kind || first.z.length !== second.z.length) return false;
  return equal(first.u, second.u) && equal(first.v, second.v);
}

/** @param {Float64Array} a @param {Float64Array} b */
function equal(a, b) {
  return a.length === b.length && a.every((value, i) => value === b[i]);
}
