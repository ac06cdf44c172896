// A flank as an image: pixels by the colour of their deviation, missing ones hatched. Pure.

import { deviationColour } from "../lib/colour.js";
import { inCell, place } from "./surface.js";

/** @typedef {import("./surface.js").FlankSurface} FlankSurface */
/** @typedef {import("./surface.js").Box} Box */
/** @typedef {{ width: number, height: number, box: Box, flipU?: boolean, flipV?: boolean }} View what is seen: `box` from edge to edge */

const STEPS = 512;

/**
 * The heights of pixels, row by row from above: u upwards, v to the right.
 * @param {FlankSurface} surface @param {View} view
 * @returns {Float32Array} NaN: missing; Infinity: outside of the nodes
 */
export function heightsOf(surface, view) {
  return surface.kind === "grid" ? ofGrid(surface, view) : ofTriangles(surface, view);
}

/** @param {import("./surface.js").Grid} grid @param {View} view */
function ofGrid({ u, v, z }, view) {
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
  for (let y = 0; y < height; y += 1) {
    const [i, s] = place(u, upwards(view, y));
    for (let x = 0; x < width; x += 1) {
      const j = /** @type {number} */ (columns[x]);
      if (i < 0 || j < 0) {
        out[y * width + x] = Number.POSITIVE_INFINITY;
        continue;
      }
      const k = i * v.length + j;
      out[y * width + x] = inCell(
        /** @type {number} */ (z[k]),
        /** @type {number} */ (z[k + next]),
        /** @type {number} */ (z[k + row]),
        /** @type {number} */ (z[k + row + next]),
        s,
        /** @type {number} */ (shares[x]),
      );
    }
  }
  return out;
}

/** @param {import("./surface.js").Scattered} surface @param {View} view */
function ofTriangles({ u, v, z, triangles }, view) {
  const { width, height } = view;
  const out = new Float32Array(width * height).fill(Number.POSITIVE_INFINITY);
  const x = Float64Array.from(v, (value) => toX(view, value) - 0.5);
  const y = Float64Array.from(u, (value) => toY(view, value) - 0.5);
  const get = (/** @type {Float64Array} */ values, /** @type {number} */ i) => /** @type {number} */ (values[i]);
  for (let k = 0; k + 2 < triangles.length; k += 3) {
    const [a, b, c] = /** @type {[number, number, number]} */ ([triangles[k], triangles[k + 1], triangles[k + 2]]);
    const [xa, ya, za] = [get(x, a), get(y, a), get(z, a)];
    const [xb, yb] = [get(x, b) - xa, get(y, b) - ya];
    const [xc, yc] = [get(x, c) - xa, get(y, c) - ya];
    const area = xb * yc - xc * yb;
    if (area === 0) continue;
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
  }
  return out;
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

/** Where a v lies in the view, in pixels from its left edge. @param {View} view @param {number} value */
export function toX({ width, box: { v }, flipV = false }, value) {
  const share = (value - v[0]) / (v[1] - v[0] || 1);
  return width * (flipV ? 1 - share : share);
}

/** Where a u lies in the view, in pixels from its upper edge. @param {View} view @param {number} value */
export function toY({ height, box: { u }, flipU = false }, value) {
  const share = (u[1] - value) / (u[1] - u[0] || 1);
  return height * (flipU ? 1 - share : share);
}

/** The place of a pixel. @param {View} view @param {number} x @param {number} y @returns {{ u: number, v: number }} */
export function placeOf(view, x, y) {
  return { u: upwards(view, y - 0.5), v: across(view, x - 0.5) };
}

/**
 * The image of heights: RGBA. Missing ones are hatched in grey, and outside it is clear.
 * @param {Float32Array} heights @param {number} width @param {number} limit of the colour scale
 * @param {number} [hatch] distance of the hatch's lines in pixels
 */
export function imageOf(heights, width, limit, hatch = 7) {
  const pixels = new Uint8ClampedArray(4 * heights.length);
  const words = new Uint32Array(pixels.buffer);
  const colours = Uint32Array.from({ length: STEPS + 1 }, (_, i) => {
    const [red, green, blue] = deviationColour((2 * i) / STEPS - 1, 1);
    return word(red, green, blue, 255);
  });
  const [line, ground] = [word(120, 128, 136, 255), word(160, 168, 176, 70)];
  const factor = limit > 0 ? STEPS / (2 * limit) : 0;
  for (let i = 0; i < heights.length; i += 1) {
    const height = /** @type {number} */ (heights[i]);
    if (height === Number.POSITIVE_INFINITY) continue;
    if (Number.isNaN(height)) {
      const [x, y] = [i % width, Math.floor(i / width)];
      words[i] = (x + y) % hatch < 1.5 ? line : ground;
      continue;
    }
    const step = Math.round(height * factor) + STEPS / 2;
    words[i] = /** @type {number} */ (colours[Math.min(STEPS, Math.max(0, step))]);
  }
  return pixels;
}

const LITTLE = new Uint8Array(new Uint32Array([1]).buffer)[0] === 1;

/** A pixel as the machine keeps it. @param {number} red @param {number} green @param {number} blue @param {number} alpha */
function word(red, green, blue, alpha) {
  const bytes = LITTLE ? [alpha, blue, green, red] : [red, green, blue, alpha];
  return bytes.reduce((whole, byte) => (whole << 8) | byte, 0) >>> 0;
}
