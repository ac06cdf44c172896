// Scales and their ticks, linear and logarithmic. Pure, but for the way numbers are written.

import { scaleLinear, scaleLog, tickStep } from "../../vendor/d3.js";
import { superscript } from "../lib/format.js";

/** @typedef {ReturnType<typeof import("../lib/format.js").formats>} Formats */
/**
 * @typedef {object} AxisSpec
 * @property {string} label
 * @property {string | undefined} [unit]
 * @property {"linear" | "log"} [scale]
 * @property {readonly [number, number]} domain in any order; a logarithmic one lies above 0
 * @property {boolean} [nice] ends at ticks
 * @property {number} [ticks] about how many
 */
/** @typedef {import("../../vendor/d3.js").ScaleContinuousNumeric<number, number>} Scale */
/** @typedef {{ value: number, label: string | null }} Tick a small one has no label */

/**
 * @param {AxisSpec} axis @param {readonly [number, number]} range
 * @returns {Scale}
 */
export function scaleOf({ scale = "linear", domain, nice = false }, range) {
  const [from, to] = widened(domain, scale);
  const made = (scale === "log" ? scaleLog() : scaleLinear())
    .domain(/** @type {[number, number]} */ ([from, to]))
    .range(range);
  return nice ? made.nice() : made;
}

/** Widens a domain of a single value. @param {readonly [number, number]} domain @param {"linear" | "log"} scale */
function widened([from, to], scale) {
  if (from !== to) return [from, to];
  if (scale === "log") return [from / 2, to * 2];
  const by = from === 0 ? 1 : Math.abs(from) / 2;
  return [from - by, to + by];
}

/**
 * @param {Scale} scale @param {AxisSpec} axis @param {Formats} formats
 * @returns {Tick[]}
 */
export function ticksOf(scale, { scale: kind = "linear", ticks = 6 }, formats) {
  const [a = 0, b = 1] = scale.domain();
  const [low, high] = [Math.min(a, b), Math.max(a, b)];
  if (kind !== "log") return linearTicks(scale, low, high, ticks, formats);
  const found = logTicks(low, high, ticks, formats);
  // within a part of a decade there may be no labelled one
  if (found.filter(({ label }) => label !== null).length > 1) return found;
  return linearTicks(scaleLinear().domain([low, high]), low, high, Math.min(ticks, 4), formats);
}

/** @param {Scale} scale @param {number} low @param {number} high @param {number} count @param {Formats} formats */
function linearTicks(scale, low, high, count, formats) {
  const step = tickStep(low, high, count);
  const decimals = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const far = Math.max(Math.abs(low), Math.abs(high)) >= 1e6 || decimals > 4;
  const write = (/** @type {number} */ value) => (far ? formats.significant(value, 3) : formats.fixed(value, decimals));
  return scale.ticks(count).map((value) => ({ value, label: write(value) }));
}

/** Returns powers of ten; within few decades also their 2 and 5, the others small. @param {number} low @param {number} high @param {number} count @param {Formats} formats */
function logTicks(low, high, count, formats) {
  const [first, last] = [Math.floor(Math.log10(low) + 1e-9), Math.ceil(Math.log10(high) - 1e-9)];
  const decades = Math.log10(high / low);
  const every = Math.max(1, Math.ceil((last - first) / count));
  const labelled = decades <= 1.2 ? [1, 2, 3, 5] : decades <= 2.5 ? [1, 2, 5] : [1];
  // one format for all labels of an axis
  const plain = first >= -3 && last <= 4;
  /** @type {Tick[]} */
  const found = [];
  for (let power = first; power <= last; power += 1) {
    for (let digit = 1; digit <= 9; digit += 1) {
      const value = Number(`${digit}e${power}`);
      if (value < low * (1 - 1e-9) || value > high * (1 + 1e-9)) continue;
      if (decades > 8 && digit > 1) continue;
      const named = labelled.includes(digit) && (power - first) % every === 0;
      found.push({ value, label: named ? written(digit, power, plain, formats) : null });
    }
  }
  return found;
}

/** @param {number} digit @param {number} power @param {boolean} plain @param {Formats} formats */
function written(digit, power, plain, formats) {
  if (plain) return formats.fixed(Number(`${digit}e${power}`), Math.max(0, -power));
  return digit === 1 ? `10${superscript(power)}` : `${digit}·10${superscript(power)}`;
}
