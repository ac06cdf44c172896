export default {
  suspected: "Suspected gross errors",
  excluded: "Left out",
  about: (/** @type {number} */ count) =>
    count === 1
      ? "One node is further off what the others say than noise explains."
      : `${count} nodes are further off what the others say than noise explains.`,
  heavyTails: "Or the errors have heavy tails: compare a fit with the estimator m_estimator.",
  check: "Check the part and the probe there before leaving anything out. What is left out stays in the trace.",
  node: (/** @type {string} */ place) => `Node ${place}`,
  cell: (/** @type {number} */ row, /** @type {number} */ column) => `row ${row}, column ${column}`,
  off: (/** @type {string} */ by, /** @type {string} */ sigmas) => `off by ${by} (${sigmas} σ)`,
  moved: (/** @type {string} */ terms) => `Without them, others by more than their intervals: ${terms}.`,
  insteadOf: (/** @type {string} */ name, /** @type {string} */ without, /** @type {string} */ value) =>
    `${name} ${without} instead of ${value}`,
  unmoved: "Without them every coefficient stays within its interval.",
  leaveOut: "Leave out",
  leaveAllOut: "Leave all out",
  takeBack: "Take back in",
  reasonOut: (/** @type {string} */ nodes) => `Left out: ${nodes}`,
  reasonBack: (/** @type {string} */ nodes) => `Taken back in: ${nodes}`,
  done: "Fitted anew; this fit stands now.",
};
