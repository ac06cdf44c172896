// A flank as triangles in space: x along the width, y from root to tip, z out of the material. Pure.

import { deviationColour } from "../lib/colour.js";
import { boxOf, gridOf } from "./surface.js";

/** @typedef {import("./surface.js").FlankSurface} FlankSurface */
/** @typedef {import("./surface.js").Box} Box */

/** Thins a grid to about this many nodes; scattered ones stay. @param {FlankSurface} surface @param {number} most @returns {FlankSurface} */
export function thinnedTo(surface, most) {
  if (surface.kind !== "grid" || surface.z.length <= most) return surface;
  const every = Math.ceil(Math.sqrt(surface.z.length / most));
  const kept = (/** @type {Float64Array} */ values) =>
    Array.from(values.keys()).filter((i) => i % every === 0 || i === values.length - 1);
  const [rows, columns] = [kept(surface.u), kept(surface.v)];
  return gridOf(
    rows.map((i) => surface.u[i] ?? 0),
    columns.map((j) => surface.v[j] ?? 0),
    rows.map((i) => columns.map((j) => surface.z[i * surface.v.length + j] ?? null)),
  );
}

/** @param {FlankSurface} surface @param {number} index @param {number} scale of the heights @param {boolean} flipU @param {Box} box @returns {[number, number, number]} */
function placeOf(surface, index, scale, flipU, { u, v }) {
  const grid = surface.kind === "grid";
  const a = surface.u[grid ? Math.floor(index / surface.v.length) : index] ?? 0;
  const b = surface.v[grid ? index % surface.v.length : index] ?? 0;
  const z = surface.z[index] ?? Number.NaN;
  const y = a - (u[0] + u[1]) / 2;
  return [b - (v[0] + v[1]) / 2, flipU ? -y : y, Number.isNaN(z) ? 0 : z * scale];
}

/** @param {FlankSurface} surface @param {number} limit @param {number} scale @param {boolean} flipU @param {Box} box */
export function verticesOf(surface, limit, scale, flipU, box) {
  const count = surface.z.length;
  const [positions, colours] = [new Float32Array(3 * count), new Float32Array(3 * count)];
  for (let i = 0; i < count; i += 1) {
    positions.set(placeOf(surface, i, scale, flipU, box), 3 * i);
    const [red, green, blue] = deviationColour(surface.z[i] ?? 0, limit);
    // colours are given as light, not as the screen's values
    colours.set([linear(red), linear(green), linear(blue)], 3 * i);
  }
  return { positions, colours };
}

/** @param {number} value of sRGB, 0…255 */
function linear(value) {
  const share = value / 255;
  return share <= 0.04045 ? share / 12.92 : ((share + 0.055) / 1.055) ** 2.4;
}

/** Returns the triangles without missing nodes. @param {FlankSurface} surface */
export function indicesOf(surface) {
  if (surface.kind === "scattered") return surface.triangles;
  const [rows, columns] = [surface.u.length, surface.v.length];
  /** @type {number[]} */
  const found = [];
  const add = (/** @type {number} */ a, /** @type {number} */ b, /** @type {number} */ c) => {
    if (![a, b, c].some((i) => Number.isNaN(surface.z[i] ?? Number.NaN))) found.push(a, b, c);
  };
  for (let i = 0; i + 1 < rows; i += 1) {
    for (let j = 0; j + 1 < columns; j += 1) {
      const k = i * columns + j;
      const missing =
        Number.isNaN(surface.z[k] ?? Number.NaN) || Number.isNaN(surface.z[k + columns + 1] ?? Number.NaN);
      if (missing) {
        add(k, k + 1, k + columns);
        add(k + 1, k + columns + 1, k + columns);
      } else {
        add(k, k + 1, k + columns + 1);
        add(k, k + columns + 1, k + columns);
      }
    }
  }
  return Uint32Array.from(found);
}

/** Approximate number of grid lines drawn in each direction. */
const LINES = 20;

/**
 * Returns grid lines as pairs of points, each through all of its nodes, so that it lies on the
 * surface; of a fine grid only about every fifth line. With scale 0 they lie on the nominal plane.
 * @param {FlankSurface} surface @param {number} scale @param {boolean} flipU @param {Box} box
 */
export function linesOf(surface, scale, flipU, box) {
  /** @type {number[]} */
  const found = [];
  const add = (/** @type {number} */ a, /** @type {number} */ b) => {
    if (scale !== 0 && (Number.isNaN(surface.z[a] ?? Number.NaN) || Number.isNaN(surface.z[b] ?? Number.NaN))) return;
    found.push(...placeOf(surface, a, scale, flipU, box), ...placeOf(surface, b, scale, flipU, box));
  };
  if (surface.kind === "grid") {
    const [rows, columns] = [surface.u.length, surface.v.length];
    const every = Math.max(1, Math.floor(Math.max(rows, columns) / LINES));
    const drawn = (/** @type {number} */ i, /** @type {number} */ count) => i % every === 0 || i === count - 1;
    for (let i = 0; i < rows; i += 1) {
      for (let j = 0; j < columns; j += 1) {
        const k = i * columns + j;
        if (j + 1 < columns && drawn(i, rows)) add(k, k + 1);
        if (i + 1 < rows && drawn(j, columns)) add(k, k + columns);
      }
    }
  } else if (scale === 0) {
    const [x, y] = [(box.v[1] - box.v[0]) / 2, (box.u[1] - box.u[0]) / 2];
    found.push(-x, -y, 0, x, -y, 0, x, -y, 0, x, y, 0, x, y, 0, -x, y, 0, -x, y, 0, -x, -y, 0);
  }
  return Float32Array.from(found);
}

/** @typedef {{ yaw: number, pitch: number, zoom: number }} Camera angles in degrees */
/** @typedef {{ width: number, height: number, radius: number }} Frame pixels, and how far from the middle is seen at zoom 1 */

const RADIANS = Math.PI / 180;
/** The factor by which the flank fills more of the picture than a ball around it. */
export const CLOSER = 1.6;

/**
 * Returns the projection of points: pixels from the upper left corner of the picture, and depth.
 * @param {Camera} camera @param {Frame} frame
 * @returns {(x: number, y: number, z: number) => [number, number, number]}
 */
export function projection({ yaw, pitch, zoom }, { width, height, radius }) {
  const [a, b] = [RADIANS * (yaw - 90), RADIANS * pitch];
  const [cosA, sinA, cosB, sinB] = [Math.cos(a), Math.sin(a), Math.cos(b), Math.sin(b)];
  const scale = (Math.min(width, height) * zoom * CLOSER) / (2 * radius);
  return (x, y, z) => [
    width / 2 + scale * (cosA * y - sinA * x),
    height / 2 - scale * (cosB * z - sinB * (cosA * x + sinA * y)),
    cosB * (cosA * x + sinA * y) + sinB * z,
  ];
}

/** The distance of a word from its edge, pixels. */
const ASIDE = 6;

/**
 * Places the words of the four edges in the picture: outside of the middle of each edge (the
 * nominal plane's or the surface's, whichever is further out), and within the picture. Of a pair
 * that overlaps, seen along the flank, only the nearer is shown.
 * @template {string} K
 * @param {Box} box @param {ReturnType<typeof projection>} project @param {{ width: number, height: number }} frame
 * @param {Record<K, string>} words @param {Record<K, readonly [number, number]>} sides towards which side each lies, along the width and upwards: −1, 0, 1
 * @param {Record<K, number>} heights of the surface there, as drawn
 * @param {{ letter: number, line: number }} size about what a letter and a line need, pixels
 * @returns {{ key: K, text: string, x: number, y: number }[]}
 */
export function edgeWords({ u, v }, project, frame, words, sides, heights, { letter, line }) {
  const keys = /** @type {K[]} */ (Object.keys(words));
  const [middleX, middleY] = project(0, 0, 0);
  const within = (/** @type {number} */ at, /** @type {number} */ half, /** @type {number} */ most) =>
    Math.min(most - half - 2, Math.max(half + 2, at));
  return keys.flatMap((key) => {
    const [across, up] = sides[key];
    const place = /** @type {const} */ ([(across * (v[1] - v[0])) / 2, (up * (u[1] - u[0])) / 2]);
    const [x, plane, near] = project(...place, 0);
    const [dx, dy] = [x - middleX, plane - middleY];
    const far = Math.hypot(dx, dy);
    if (far < line && near < 0) return [];
    const [outX, outY] = far < 1 ? [0, 1] : [dx / far, dy / far];
    const [halfX, halfY] = [(letter * words[key].length) / 2, line / 2];
    // heights are upright in the picture
    const seen = project(...place, heights[key])[1];
    const y = outY < 0 ? Math.min(plane, seen) : Math.max(plane, seen);
    const by = ASIDE + halfX * Math.abs(outX) + halfY * Math.abs(outY);
    return [
      {
        key,
        text: words[key],
        x: within(x + by * outX, halfX, frame.width),
        y: within(y + by * outY, halfY, frame.height),
      },
    ];
  });
}

/** A node in the picture. @param {FlankSurface} surface @param {number} index @param {number} scale @param {boolean} flipU @param {ReturnType<typeof projection>} project */
export function nodeInPicture(surface, index, scale, flipU, project) {
  const [x, y, z] = placeOf(surface, index, scale, flipU, boxOf(surface));
  return project(x, y, z);
}

/**
 * Returns the node nearest to a place of the picture: of the foremost triangle there; undefined
 * outside the flank.
 * @param {FlankSurface} surface @param {number} scale @param {boolean} flipU @param {ReturnType<typeof projection>} project
 * @param {readonly [number, number]} at
 */
export function nodeSeenAt(surface, scale, flipU, project, [px, py]) {
  const count = surface.z.length;
  const box = boxOf(surface);
  const seen = new Float64Array(3 * count);
  for (let i = 0; i < count; i += 1) seen.set(project(...placeOf(surface, i, scale, flipU, box)), 3 * i);
  const triangles = indicesOf(surface);
  let [best, nearest] = [-1, Number.NEGATIVE_INFINITY];
  for (let k = 0; k + 2 < triangles.length; k += 3) {
    const [a, b, c] = [triangles[k] ?? 0, triangles[k + 1] ?? 0, triangles[k + 2] ?? 0];
    const [ax, ay] = [seen[3 * a] ?? 0, seen[3 * a + 1] ?? 0];
    const [bx, by] = [seen[3 * b] ?? 0, seen[3 * b + 1] ?? 0];
    const [cx, cy] = [seen[3 * c] ?? 0, seen[3 * c + 1] ?? 0];
    const whole = cross(bx - ax, by - ay, cx - ax, cy - ay);
    if (whole === 0) continue;
    const p = cross(px - ax, py - ay, cx - ax, cy - ay) / whole;
    const q = cross(bx - ax, by - ay, px - ax, py - ay) / whole;
    if (p < 0 || q < 0 || p + q > 1) continue;
    const [near, onB, onC] = [seen[3 * a + 2] ?? 0, seen[3 * b + 2] ?? 0, seen[3 * c + 2] ?? 0];
    const depth = near + p * (onB - near) + q * (onC - near);
    if (depth <= nearest) continue;
    nearest = depth;
    best = p >= q && p >= 1 - p - q ? b : q >= 1 - p - q ? c : a;
  }
  return best < 0 ? undefined : best;
}

/** @param {number} ax @param {number} ay @param {number} bx @param {number} by */
const cross = (ax, ay, bx, by) => ax * by - ay * bx;
