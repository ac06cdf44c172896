/** @type {import("../i18n.js").Same<typeof import("../en/strip.js").default>} */
export default {
  estimate: "Schätzwert",
  error: "± Standardfehler",
  interval: "Intervall",
  bias: "± Schranke der Verzerrung",
  leastSquares: "kleinste Quadrate",
  limits: "innerhalb der Grenzen",
  zero: "null",
  rowScale: "Jede Zeile hat ihren eigenen Maßstab.",
  columnScale: "Alle einer Spalte haben denselben Maßstab.",
  intervalFrom: (/** @type {string} */ ends) => `Intervall ${ends}`,
  biasOf: (/** @type {string} */ most) => `Verzerrung höchstens ${most}`,
  leastSquaresOf: (/** @type {string} */ value) => `kleinste Quadrate ${value}`,
  limitsOf: (/** @type {string} */ ends) => `Grenzen ${ends}`,
};
