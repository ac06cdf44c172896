// Numbers as pages show them, against those of the interface.

import assert from "node:assert/strict";

/**
 * Checks displayed numbers in their order: they have to be the interface's to their last digit.
 * @param {string | null | undefined} text @param {...(number | undefined)} values
 */
export function agrees(text, ...values) {
  const written = [...(text ?? "").matchAll(/[−+]?\d+(\.\d+)?/g)].map(([one]) => one);
  assert.ok(written.length >= values.length, `${values.length} numbers in ${text}`);
  for (const [i, value] of values.entries()) {
    assert.ok(value !== undefined, `${text}: the interface says nothing`);
    const decimals = written[i]?.split(".")[1]?.length ?? 0;
    assert.equal(Number(written[i]?.replace("−", "-")), Number(value.toFixed(decimals)) + 0, text ?? "");
  }
}

const UNITS = ["µm", "µm/mm", "µm/mm²", "µm/mm³", "µm/mm⁴"];

/** Returns the unit of a coefficient of heights in µm over mm, by its degrees. @param {{ powers: number[] }} coefficient */
export const unitOf = ({ powers }) => UNITS[powers.reduce((sum, one) => sum + one, 0)] ?? "";
