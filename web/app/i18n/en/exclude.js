export default {
  suspected: "Suspected gross errors",
  excluded: "Excluded",
  about: (/** @type {number} */ count) =>
    count === 1
      ? "One node deviates from the others by more than noise explains."
      : `${count} nodes deviate from the others by more than noise explains.`,
  heavyTails: "Alternatively, the errors have heavy tails: compare with the estimator m_estimator.",
  check: "Check the part and the probe at this place before excluding nodes. Exclusions are recorded in the trace.",
  node: (/** @type {string} */ place) => `Node ${place}`,
  cell: (/** @type {number} */ row, /** @type {number} */ column) => `row ${row}, column ${column}`,
  off: (/** @type {string} */ by, /** @type {string} */ sigmas) => `off by ${by} (${sigmas} σ)`,
  moved: (/** @type {string} */ terms) =>
    `Excluding them changes these coefficients by more than their intervals: ${terms}.`,
  insteadOf: (/** @type {string} */ name, /** @type {string} */ without, /** @type {string} */ value) =>
    `${name} ${without} instead of ${value}`,
  unmoved: "Excluding them leaves every coefficient within its interval.",
  leaveOut: "Exclude",
  leaveAllOut: "Exclude all",
  takeBack: "Include again",
  reasonOut: (/** @type {string} */ nodes) => `Excluded: ${nodes}`,
  reasonBack: (/** @type {string} */ nodes) => `Included again: ${nodes}`,
  done: "Fitted again; the new fit is now the chosen one.",
};
