// Differences of colours as people see them: CIEDE2000 (Sharma, Wu, Dalal 2005) of CIELAB under
// D65, and sRGB without red or green cones (Machado, Oliveira, Fernandes 2009, severity 1).

/** @typedef {readonly [number, number, number]} Triple */

/** @type {Record<"everybody" | "protan" | "deutan", readonly [Triple, Triple, Triple]>} */
const EYES = {
  everybody: [
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
  ],
  protan: [
    [0.152286, 1.052583, -0.204868],
    [0.114503, 0.786281, 0.099216],
    [-0.003882, -0.048116, 1.051998],
  ],
  deutan: [
    [0.367322, 0.860646, -0.227968],
    [0.280085, 0.672501, 0.047413],
    [-0.01182, 0.04294, 0.968881],
  ],
};
const TO_XYZ = /** @type {const} */ ([
  [0.4124564, 0.3575761, 0.1804375],
  [0.2126729, 0.7151522, 0.072175],
  [0.0193339, 0.119192, 0.9503041],
]);
const WHITE = /** @type {const} */ ([0.95047, 1, 1.08883]);

/** Converts a colour of 0…255 to CIELAB as an eye sees it. @param {keyof typeof EYES} eye @param {Triple} rgb @returns {Triple} */
export function seenBy(eye, rgb) {
  const linear = /** @type {Triple} */ (/** @type {unknown} */ (rgb.map((value) => linearOf(value / 255))));
  const seen = times(EYES[eye], linear);
  const clipped = /** @type {Triple} */ (/** @type {unknown} */ (seen.map((value) => Math.min(1, Math.max(0, value)))));
  const [x, y, z] = times(TO_XYZ, clipped);
  const [fx, fy, fz] = [f(x / WHITE[0]), f(y / WHITE[1]), f(z / WHITE[2])];
  return [116 * fy - 16, 500 * (fx - fy), 200 * (fy - fz)];
}

/** @param {readonly [Triple, Triple, Triple]} rows @param {Triple} v @returns {Triple} */
function times(rows, v) {
  const dot = (/** @type {Triple} */ row) => row[0] * v[0] + row[1] * v[1] + row[2] * v[2];
  return [dot(rows[0]), dot(rows[1]), dot(rows[2])];
}

/** @param {number} value */
const linearOf = (value) => (value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4);
/** @param {number} t */
const f = (t) => (t > (6 / 29) ** 3 ? Math.cbrt(t) : t / (3 * (6 / 29) ** 2) + 4 / 29);
/** @param {number} angle */
const radians = (angle) => (angle * Math.PI) / 180;

/** @param {Triple} one @param {Triple} other */
export function ciede2000([l1, a1, b1], [l2, a2, b2]) {
  const meanC = (Math.hypot(a1, b1) + Math.hypot(a2, b2)) / 2;
  const g = 0.5 * (1 - Math.sqrt(meanC ** 7 / (meanC ** 7 + 25 ** 7)));
  const [p1, p2] = [(1 + g) * a1, (1 + g) * a2];
  const [c1, c2] = [Math.hypot(p1, b1), Math.hypot(p2, b2)];
  const hue = (/** @type {number} */ a, /** @type {number} */ b) =>
    a === 0 && b === 0 ? 0 : (Math.atan2(b, a) * 180) / Math.PI + (b < 0 ? 360 : 0);
  const [h1, h2] = [hue(p1, b1), hue(p2, b2)];
  const grey = c1 * c2 === 0;
  let dh = grey ? 0 : h2 - h1;
  if (dh > 180) dh -= 360;
  else if (dh < -180) dh += 360;
  const dH = 2 * Math.sqrt(c1 * c2) * Math.sin(radians(dh / 2));
  const [l, c] = [(l1 + l2) / 2, (c1 + c2) / 2];
  let h = h1 + h2;
  if (!grey) h = Math.abs(h1 - h2) <= 180 ? h / 2 : h < 360 ? (h + 360) / 2 : (h - 360) / 2;
  const t =
    1 -
    0.17 * Math.cos(radians(h - 30)) +
    0.24 * Math.cos(radians(2 * h)) +
    0.32 * Math.cos(radians(3 * h + 6)) -
    0.2 * Math.cos(radians(4 * h - 63));
  const sl = 1 + (0.015 * (l - 50) ** 2) / Math.sqrt(20 + (l - 50) ** 2);
  const sc = 1 + 0.045 * c;
  const sh = 1 + 0.015 * c * t;
  const rt = -2 * Math.sqrt(c ** 7 / (c ** 7 + 25 ** 7)) * Math.sin(radians(60 * Math.exp(-(((h - 275) / 25) ** 2))));
  const [x, y, z] = [(l2 - l1) / sl, (c2 - c1) / sc, dH / sh];
  return Math.sqrt(x * x + y * y + z * z + rt * y * z);
}
