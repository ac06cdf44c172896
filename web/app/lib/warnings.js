// Warnings as a list. Pure.

/** @typedef {{ code: string, message: string }} Warning */

/** Each warning once, with how often it is said. @param {readonly Warning[]} warnings */
export function counted(warnings) {
  /** @type {Map<string, { warning: Warning, times: number }>} */
  const all = new Map();
  for (const warning of warnings) {
    const key = `${warning.code} ${warning.message}`;
    all.set(key, { warning, times: (all.get(key)?.times ?? 0) + 1 });
  }
  return [...all].map(([key, one]) => ({ key, ...one }));
}

/** A message as a reader reads it: names without the quotes of code, numbers with six digits at most. @param {string} message */
export const plain = (message) =>
  message.replaceAll("`", "").replace(/\d+\.\d{6,}/g, (digits) => String(Number(Number(digits).toPrecision(6))));
