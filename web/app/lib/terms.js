// Terms of models in mathematical notation. Pure.

/** Formats `u^2*v` in mathematical notation. @param {string | null | undefined} term */
export function termSign(term) {
  const raised = /** @type {Record<string, string>} */ ({
    2: "²",
    3: "³",
    4: "⁴",
    5: "⁵",
    6: "⁶",
    7: "⁷",
    8: "⁸",
    9: "⁹",
  });
  return (term ?? "")
    .replaceAll(/\^(\d)(?!\d)/g, (_, digit) => raised[digit] ?? `^${digit}`)
    .replaceAll(/\b([A-Z])(\d)(?=\()/g, (_, name, digit) => name + "₀₁₂₃₄₅₆₇₈₉"[Number(digit)])
    .replaceAll("*", "\u202f");
}
