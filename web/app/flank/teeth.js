// Deviations of several teeth as surfaces, one for each flank of a tooth. Pure, but for the triangles.

import { countsOf, extremesOf, gridOf } from "./surface.js";
import { scatteredOf } from "./triangles.js";

/** @typedef {import("./surface.js").FlankSurface} FlankSurface */
/** @typedef {import("../api/client.js").Schema<"GearDeviations">} GearDeviations */
/** @typedef {{ key: string, tooth: number, flank: "left" | "right", surface: FlankSurface }} ToothFlank `u`: roll length, `v`: along the axis, mm; heights in µm */

/** Sorts left flanks first, then by tooth. @param {ToothFlank} a @param {ToothFlank} b */
const inOrder = (a, b) => (a.flank === b.flank ? a.tooth - b.tooth : a.flank === "left" ? -1 : 1);

/**
 * Returns each flank with deviations; of several measurements of a flank the last one counts.
 * @param {readonly GearDeviations[]} results in the order in which they were made @returns {ToothFlank[]}
 */
export function flanksOf(results) {
  /** @type {Map<string, ToothFlank>} */
  const found = new Map();
  for (const result of results)
    for (const [key, { tooth, flank, points }] of pointsOf(result)) {
      const surface = points.some(({ z }) => Number.isFinite(z)) ? surfaceOf(points) : undefined;
      if (surface) found.set(key, { key, tooth, flank, surface });
    }
  return [...found.values()].sort(inOrder);
}

/** @typedef {{ u: number, v: number, z: number }} Point `z` is NaN where the deviation is undefined */

/** @param {GearDeviations} result */
function pointsOf({ deviation_um: z, roll_length_mm: u, z_mm: v, tooth, flank }) {
  /** @type {Map<string, { tooth: number, flank: "left" | "right", points: Point[] }>} */
  const found = new Map();
  for (const [i, of] of tooth.entries()) {
    const side = flank[i];
    const [atU, atV] = [u[i], v[i]];
    // a point without a place is dropped
    if (of === 0 || side === undefined || typeof atU !== "number" || typeof atV !== "number") continue;
    const key = `${of}-${side}`;
    const one = found.get(key) ?? { tooth: of, flank: side, points: [] };
    one.points.push({ u: atU, v: atV, z: z[i] ?? Number.NaN });
    found.set(key, one);
  }
  return found;
}

/** Makes a grid if the points form one, else triangles. @param {readonly Point[]} points */
function surfaceOf(points) {
  const [us, vs] = [ascending(points.map(({ u }) => u)), ascending(points.map(({ v }) => v))];
  if (us.length < 2 || vs.length < 2 || us.length * vs.length > 4 * points.length)
    return scatteredOf(
      points.map(({ u }) => u),
      points.map(({ v }) => v),
      points.map(({ z }) => z),
    );
  const rows = us.map(() => new Array(vs.length).fill(null));
  const [rowOf, columnOf] = [us, vs].map((all) => new Map(all.map((value, i) => [value, i])));
  for (const { u, v, z } of points) {
    const row = rows[rowOf?.get(u) ?? -1];
    if (row && Number.isFinite(z)) row[columnOf?.get(v) ?? -1] = z;
  }
  return gridOf(us, vs, rows);
}

/** @param {readonly number[]} values each once */
const ascending = (values) => [...new Set(values)].sort((a, b) => a - b);

/** Returns the statistics of a flank for the table. @param {ToothFlank} of */
export function inFigures({ surface }) {
  const { nodes, missing } = countsOf(surface);
  const ends = extremesOf(surface);
  let [sum, squares] = [0, 0];
  for (const z of surface.z) {
    if (Number.isNaN(z)) continue;
    sum += z;
    squares += z * z;
  }
  const count = nodes - missing;
  return {
    count,
    least: ends?.least.z,
    greatest: ends?.greatest.z,
    mean: count > 0 ? sum / count : undefined,
    rms: count > 0 ? Math.sqrt(squares / count) : undefined,
  };
}

/** Returns the common range of all flanks. @param {readonly ToothFlank[]} flanks @param {"u" | "v"} axis @returns {[number, number]} */
export function commonRange(flanks, axis) {
  let [low, high] = [Number.POSITIVE_INFINITY, Number.NEGATIVE_INFINITY];
  for (const { surface } of flanks)
    for (const value of surface[axis]) [low, high] = [Math.min(low, value), Math.max(high, value)];
  return low <= high ? [low, high] : [0, 1];
}
