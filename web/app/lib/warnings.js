// Warnings as a list. Pure.

/** @typedef {{ code: string, message: string }} Warning */

/** Returns each warning once, with its count. @param {readonly Warning[]} warnings */
export function counted(warnings) {
  /** @type {Map<string, { warning: Warning, times: number }>} */
  const all = new Map();
  for (const warning of warnings) {
    const key = `${warning.code} ${warning.message}`;
    all.set(key, { warning, times: (all.get(key)?.times ?? 0) + 1 });
  }
  return [...all].map(([key, one]) => ({ key, ...one }));
}

/** Formats a message for reading: names without the quotes of code, numbers without the noise of their last decimals. @param {string} message */
export const plain = (message) => message.replaceAll("`", "").replace(/(\d+)\.(\d+)/g, shortened);

/**
 * Rounds more than 8 decimals to 6, without zeros at their end; zeros before the first digit do not
 * count.
 * @param {string} number @param {string} whole @param {string} decimals
 */
function shortened(number, whole, decimals) {
  const leading = /^0+$/.test(whole) ? decimals.search(/[1-9]|$/) : 0;
  if (decimals.length - leading <= 8) return number;
  const places = leading + 6;
  const up = (decimals[places] ?? "0") >= "5" ? 1n : 0n;
  const all = String(BigInt(whole + decimals.slice(0, places)) + up).padStart(places + 1, "0");
  return `${all.slice(0, -places)}.${all.slice(-places)}`.replace(/\.?0+$/, "");
}
