// A PNG with a palette of 256 colours, which is a third of the size and looks the same: colours of
// data are ramps, all others few. Median cut over the colours, then the nearest of each.

import { crc32, deflateSync, inflateSync } from "node:zlib";

const SIGNATURE = Buffer.from([0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a]);
const COLOURS = 256;

/** @typedef {[number, number, number]} Rgb */
/** @typedef {{ colours: [number, number][] }} Box colours as 0xRRGGBB with their counts */

/** @param {Buffer} png of 8 bits for each of red, green, blue (and alpha), not interlaced @returns {Buffer} */
export function palettePng(png) {
  const { width, height, rgb } = decoded(png);
  /** @type {Map<number, number>} */
  const counts = new Map();
  for (const colour of rgb) counts.set(colour, (counts.get(colour) ?? 0) + 1);
  const palette = paletteOf(counts);
  /** @type {Map<number, number>} */
  const index = new Map();
  for (const colour of counts.keys()) index.set(colour, nearest(palette, colour));
  const rows = Buffer.alloc((width + 1) * height);
  for (let y = 0; y < height; y += 1)
    for (let x = 0; x < width; x += 1) rows[y * (width + 1) + 1 + x] = index.get(rgb[y * width + x] ?? 0) ?? 0;
  const head = Buffer.alloc(13);
  head.writeUInt32BE(width, 0);
  head.writeUInt32BE(height, 4);
  head.set([8, 3, 0, 0, 0], 8);
  return Buffer.concat([
    SIGNATURE,
    chunk("IHDR", head),
    chunk("PLTE", Buffer.from(palette.flat())),
    chunk("IDAT", deflateSync(rows, { level: 9 })),
    chunk("IEND", Buffer.alloc(0)),
  ]);
}

/** @param {string} type @param {Buffer} data */
function chunk(type, data) {
  const body = Buffer.concat([Buffer.from(type, "latin1"), data]);
  const ends = Buffer.alloc(8);
  ends.writeUInt32BE(data.length, 0);
  ends.writeUInt32BE(crc32(body), 4);
  return Buffer.concat([ends.subarray(0, 4), body, ends.subarray(4)]);
}

/** @param {Buffer} png */
function decoded(png) {
  const [width, height] = [png.readUInt32BE(16), png.readUInt32BE(20)];
  const channels = { 2: 3, 6: 4 }[png[25] ?? 0];
  if (png[24] !== 8 || png[28] !== 0 || !channels) throw new Error("not a PNG as browsers make them");
  /** @type {Buffer[]} */
  const parts = [];
  for (let at = 8; at < png.length; ) {
    const size = png.readUInt32BE(at);
    if (png.toString("latin1", at + 4, at + 8) === "IDAT") parts.push(png.subarray(at + 8, at + 8 + size));
    at += size + 12;
  }
  const bytes = unfiltered(inflateSync(Buffer.concat(parts)), width * channels, channels);
  const rgb = new Uint32Array(width * height);
  for (let i = 0; i < rgb.length; i += 1) {
    const at = i * channels;
    rgb[i] = ((bytes[at] ?? 0) << 16) | ((bytes[at + 1] ?? 0) << 8) | (bytes[at + 2] ?? 0);
  }
  return { width, height, rgb };
}

/** Undoes the filters of the lines. @param {Buffer} lines @param {number} length of a line @param {number} step of a pixel */
function unfiltered(lines, length, step) {
  const height = lines.length / (length + 1);
  const bytes = new Uint8Array(length * height);
  for (let y = 0; y < height; y += 1) {
    const filter = lines[y * (length + 1)];
    for (let x = 0; x < length; x += 1) {
      const left = x >= step ? (bytes[y * length + x - step] ?? 0) : 0;
      const up = y > 0 ? (bytes[(y - 1) * length + x] ?? 0) : 0;
      const corner = x >= step && y > 0 ? (bytes[(y - 1) * length + x - step] ?? 0) : 0;
      const guess = [0, left, up, (left + up) >> 1, paeth(left, up, corner)][filter ?? 0] ?? 0;
      bytes[y * length + x] = (lines[y * (length + 1) + 1 + x] ?? 0) + guess;
    }
  }
  return bytes;
}

/** @param {number} left @param {number} up @param {number} corner */
function paeth(left, up, corner) {
  const guess = left + up - corner;
  const [a, b, c] = [Math.abs(guess - left), Math.abs(guess - up), Math.abs(guess - corner)];
  if (a <= b && a <= c) return left;
  return b <= c ? up : corner;
}

/** @param {number} colour @returns {Rgb} */
const split = (colour) => [colour >> 16, (colour >> 8) & 255, colour & 255];

/** @param {Map<number, number>} counts @returns {Rgb[]} */
function paletteOf(counts) {
  /** @type {[number, number][][]} */
  const boxes = [[...counts]];
  while (boxes.length < COLOURS) {
    const widest = boxes.map((box) => ({ box, ...spreadOf(box) })).reduce((a, b) => (b.spread > a.spread ? b : a));
    if (widest.spread === 0) break;
    const sorted = widest.box.sort(([a], [b]) => (split(a)[widest.axis] ?? 0) - (split(b)[widest.axis] ?? 0));
    const middle = sorted.length >> 1;
    boxes.splice(boxes.indexOf(widest.box), 1, sorted.slice(0, middle), sorted.slice(middle));
  }
  return boxes.map(meanOf);
}

/** @param {readonly [number, number][]} box */
function spreadOf(box) {
  let best = { spread: 0, axis: 0 };
  for (const axis of [0, 1, 2]) {
    let [least, most] = [255, 0];
    for (const [colour] of box) {
      const value = split(colour)[axis] ?? 0;
      [least, most] = [Math.min(least, value), Math.max(most, value)];
    }
    // rare colours at far ends matter less than wide ramps
    const spread = (most - least) * Math.sqrt(box.length);
    if (most > least && spread > best.spread) best = { spread, axis };
  }
  return best;
}

/** The colour of a box: its commonest where that is most of it (grounds, inks), else the mean. @param {readonly [number, number][]} box @returns {Rgb} */
function meanOf(box) {
  const all = box.reduce((sum, [, count]) => sum + count, 0);
  const [common, most] = box.reduce((a, b) => (b[1] > a[1] ? b : a));
  if (most > all / 2) return split(common);
  const mean = (/** @type {number} */ axis) =>
    Math.round(box.reduce((sum, [colour, count]) => sum + (split(colour)[axis] ?? 0) * count, 0) / all);
  return [mean(0), mean(1), mean(2)];
}

/** @param {readonly Rgb[]} palette @param {number} colour */
function nearest(palette, colour) {
  const [r, g, b] = split(colour);
  let [best, least] = [0, Number.POSITIVE_INFINITY];
  for (const [i, one] of palette.entries()) {
    const distance = 2 * (one[0] - r) ** 2 + 4 * (one[1] - g) ** 2 + 3 * (one[2] - b) ** 2;
    if (distance < least) [best, least] = [i, distance];
  }
  return best;
}
