/** @type {import("../i18n.js").Same<typeof import("../en/decision.js").default>} */
export default {
  decision: "Entscheidung",
  none: "Noch ist nichts entschieden.",
  accept: "Annehmen",
  remachine: "Nacharbeiten",
  reject: "Verwerfen",
  sureAccept: (/** @type {number} */ number) => `Iteration ${number} annehmen`,
  sureRemachine: (/** @type {number} */ number) => `Nach Iteration ${number} nacharbeiten`,
  sureReject: (/** @type {number} */ number) => `Bei Iteration ${number} verwerfen`,
  reason: "Begründung",
  reasonHint: "Steht später im Verlauf.",
  done: (/** @type {string} */ decision) => `Entschieden: ${decision}.`,
  there: "Steht jetzt dort",
  yours: "Ihre Entscheidung",
  anyway: (/** @type {string} */ action) => `Trotzdem: ${action}`,
};
