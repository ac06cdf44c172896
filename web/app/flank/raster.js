// A flank as an image: pixels by the colour of their deviation, missing ones hatched. Pure.

import { deviationColour } from "../lib/colour.js";
import { inCell, place } from "./surface.js";

/** @typedef {import("./surface.js").FlankSurface} FlankSurface */
/** @typedef {import("./surface.js").Box} Box */
/** @typedef {{ width: number, height: number, box: Box, flipU?: boolean, flipV?: boolean }} View what is seen: `box` from edge to edge */

const STEPS = 512;

/**
 * A computation in parts, between which the caller can let the page respond.
 * @template Made
 * @typedef {Generator<undefined, Made, undefined>} InParts
 */

/** Pixels or triangles per part. */
const PART = 4096;

/** Runs all parts at once. @template Made @param {InParts<Made>} parts @returns {Made} */
function whole(parts) {
  for (;;) {
    const { done, value } = parts.next();
    if (done) return value;
  }
}

/**
 * Returns the heights of pixels, row by row from above: u upwards, v to the right.
 * @param {FlankSurface} surface @param {View} view
 * @returns {Float32Array} NaN: missing; Infinity: outside of the nodes
 */
export function heightsOf(surface, view) {
  return whole(heightsInParts(surface, view));
}

/** @param {FlankSurface} surface @param {View} view @returns {InParts<Float32Array>} */
export function heightsInParts(surface, view) {
  return surface.kind === "grid" ? ofGrid(surface, view) : ofTriangles(surface, view);
}

/** @param {import("./surface.js").Grid} grid @param {View} view @returns {InParts<Float32Array>} */
function* ofGrid({ u, v, z }, view) {
  const { width, height } = view;
  const out = new Float32Array(width * height);
  const columns = new Int32Array(width);
  const shares = new Float64Array(width);
  for (let x = 0; x < width; x += 1) {
    const [j, t] = place(v, across(view, x));
    columns[x] = j;
    shares[x] = t;
  }
  const next = v.length > 1 ? 1 : 0;
  const row = u.length > 1 ? v.length : 0;
  const rows = Math.max(1, Math.floor(PART / width));
  for (let y = 0; y < height; y += 1) {
    const [i, s] = place(u, upwards(view, y));
    ofRow(out.subarray(y * width, (y + 1) * width), {
      z,
      from: i < 0 ? -1 : i * v.length,
      next,
      row,
      s,
      columns,
      shares,
    });
    if (y % rows === rows - 1) yield;
  }
  return out;
}

/**
 * Computes a row of pixels.
 * @param {Float32Array} out
 * @param {{ z: Float64Array, from: number, next: number, row: number, s: number, columns: Int32Array, shares: Float64Array }} nodes
 *   `from`: the first node below the row, -1 outside; `next`, `row`: how far on the next nodes are; `s`: the share between them
 */
function ofRow(out, { z, from, next, row, s, columns, shares }) {
  for (let x = 0; x < out.length; x += 1) {
    const j = /** @type {number} */ (columns[x]);
    if (from < 0 || j < 0) {
      out[x] = Number.POSITIVE_INFINITY;
      continue;
    }
    const k = from + j;
    const t = /** @type {number} */ (shares[x]);
    const a = /** @type {number} */ (z[k]);
    const b = /** @type {number} */ (z[k + next]);
    const c = /** @type {number} */ (z[k + row]);
    const d = /** @type {number} */ (z[k + row + next]);
    const value = (1 - s) * ((1 - t) * a + t * b) + s * ((1 - t) * c + t * d);
    // only if a corner is missing
    out[x] = Number.isNaN(value) ? inCell(a, b, c, d, s, t) : value;
  }
}

/** @param {import("./surface.js").Scattered} surface @param {View} view @returns {InParts<Float32Array>} */
function* ofTriangles({ u, v, z, triangles }, view) {
  const { width, height } = view;
  const out = new Float32Array(width * height).fill(Number.POSITIVE_INFINITY);
  const x = Float64Array.from(v, (value) => toX(view, value) - 0.5);
  const y = Float64Array.from(u, (value) => toY(view, value) - 0.5);
  yield;
  let done = 0;
  for (let k = 0; k + 2 < triangles.length; k += 3) {
    const corners = /** @type {[number, number, number]} */ ([triangles[k], triangles[k + 1], triangles[k + 2]]);
    done += 1 + fillTriangle(out, width, height, { x, y, z }, corners);
    if (done < PART) continue;
    done = 0;
    yield;
  }
  return out;
}

/**
 * @param {Float32Array} out @param {number} width @param {number} height
 * @param {{ x: Float64Array, y: Float64Array, z: Float64Array }} nodes in pixels @param {readonly [number, number, number]} corners
 * @returns {number} how many pixels were looked at
 */
function fillTriangle(out, width, height, { x, y, z }, [a, b, c]) {
  const get = (/** @type {Float64Array} */ values, /** @type {number} */ i) => /** @type {number} */ (values[i]);
  const [xa, ya, za] = [get(x, a), get(y, a), get(z, a)];
  const [xb, yb] = [get(x, b) - xa, get(y, b) - ya];
  const [xc, yc] = [get(x, c) - xa, get(y, c) - ya];
  const area = xb * yc - xc * yb;
  if (area === 0) return 0;
  const [zb, zc] = [get(z, b) - za, get(z, c) - za];
  const top = Math.max(0, Math.ceil(ya + Math.min(0, yb, yc)));
  const bottom = Math.min(height - 1, Math.floor(ya + Math.max(0, yb, yc)));
  const left = Math.max(0, Math.ceil(xa + Math.min(0, xb, xc)));
  const right = Math.min(width - 1, Math.floor(xa + Math.max(0, xb, xc)));
  for (let py = top; py <= bottom; py += 1) {
    for (let px = left; px <= right; px += 1) {
      const s = ((px - xa) * yc - (py - ya) * xc) / area;
      const t = ((py - ya) * xb - (px - xa) * yb) / area;
      if (s >= -1e-9 && t >= -1e-9 && s + t <= 1 + 1e-9) out[py * width + px] = za + s * zb + t * zc;
    }
  }
  return Math.max(0, bottom - top + 1) * Math.max(0, right - left + 1);
}

/** @param {View} view @param {number} x a pixel */
function across({ width, box: { v }, flipV = false }, x) {
  const share = (x + 0.5) / width;
  return v[0] + (flipV ? 1 - share : share) * (v[1] - v[0]);
}

/** @param {View} view @param {number} y a pixel */
function upwards({ height, box: { u }, flipU = false }, y) {
  const share = (y + 0.5) / height;
  return u[1] - (flipU ? 1 - share : share) * (u[1] - u[0]);
}

/** Returns the pixels of a v from the left edge of the view. @param {View} view @param {number} value */
export function toX({ width, box: { v }, flipV = false }, value) {
  const share = (value - v[0]) / (v[1] - v[0] || 1);
  return width * (flipV ? 1 - share : share);
}

/** Returns the pixels of a u from the upper edge of the view. @param {View} view @param {number} value */
export function toY({ height, box: { u }, flipU = false }, value) {
  const share = (u[1] - value) / (u[1] - u[0] || 1);
  return height * (flipU ? 1 - share : share);
}

/** Returns the place of a pixel. @param {View} view @param {number} x @param {number} y @returns {{ u: number, v: number }} */
export function placeOf(view, x, y) {
  return { u: upwards(view, y - 0.5), v: across(view, x - 0.5) };
}

/**
 * Returns the RGBA image of heights. Missing ones are hatched in grey; outside it is transparent.
 * @param {Float32Array} heights @param {number} width @param {number} limit of the colour scale
 * @param {number} [hatch] distance of the hatch's lines in pixels
 */
export function imageOf(heights, width, limit, hatch = 7) {
  return whole(imageInParts(heights, width, limit, hatch));
}

/** @param {Float32Array} heights @param {number} width @param {number} limit @param {number} hatch @returns {InParts<Uint8ClampedArray<ArrayBuffer>>} */
export function* imageInParts(heights, width, limit, hatch) {
  const pixels = new Uint8ClampedArray(4 * heights.length);
  const words = new Uint32Array(pixels.buffer);
  for (let from = 0; from < heights.length; from += PART) {
    colour(words, heights, from, Math.min(heights.length, from + PART), { width, limit, hatch });
    yield;
  }
  return pixels;
}

/** @param {Uint32Array} words @param {Float32Array} heights @param {number} from @param {number} to @param {{ width: number, limit: number, hatch: number }} how */
function colour(words, heights, from, to, { width, limit, hatch }) {
  const factor = limit > 0 ? STEPS / (2 * limit) : 0;
  for (let i = from; i < to; i += 1) {
    const height = /** @type {number} */ (heights[i]);
    if (height === Number.POSITIVE_INFINITY) continue;
    if (Number.isNaN(height)) {
      const [x, y] = [i % width, Math.floor(i / width)];
      words[i] = (x + y) % hatch < 1.5 ? LINE : GROUND;
      continue;
    }
    const step = Math.round(height * factor) + STEPS / 2;
    words[i] = /** @type {number} */ (COLOURS[Math.min(STEPS, Math.max(0, step))]);
  }
}

const LITTLE = new Uint8Array(new Uint32Array([1]).buffer)[0] === 1;

/** Packs a pixel in the byte order of the machine. @param {number} red @param {number} green @param {number} blue @param {number} alpha */
function word(red, green, blue, alpha) {
  const bytes = LITTLE ? [alpha, blue, green, red] : [red, green, blue, alpha];
  return bytes.reduce((whole, byte) => (whole << 8) | byte, 0) >>> 0;
}

const COLOURS = Uint32Array.from({ length: STEPS + 1 }, (_, i) => {
  const [red, green, blue] = deviationColour((2 * i) / STEPS - 1, 1);
  return word(red, green, blue, 255);
});
const [LINE, GROUND] = [word(120, 128, 136, 255), word(160, 168, 176, 70)];
