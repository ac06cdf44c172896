// Times are medians of rounds.

import { asOnScreen } from "../browser/harness.js";

asOnScreen();

export const ROUNDS = 5;

/** @param {readonly number[]} values */
export function median(values) {
  const sorted = [...values].sort((a, b) => a - b);
  return /** @type {number} */ (sorted[Math.floor(sorted.length / 2)]);
}
