/** @type {typeof import("../en/exclude.js").default} */
export default {
  suspected: "Mögliche Ausreißer",
  excluded: "Weggelassen",
  about: (count) =>
    count === 1
      ? "Ein Knoten weicht stärker von den übrigen ab, als es das Rauschen erklärt."
      : `${count} Knoten weichen stärker von den übrigen ab, als es das Rauschen erklärt.`,
  heavyTails: "Oder die Fehler streuen mit breiten Enden: zum Vergleich mit dem Schätzer m_estimator anpassen.",
  check: "Vor dem Weglassen dort Teil und Taster prüfen. Was weggelassen wird, bleibt im Verlauf.",
  node: (place) => `Knoten ${place}`,
  cell: (row, column) => `Zeile ${row}, Spalte ${column}`,
  off: (by, sigmas) => `${by} daneben (${sigmas} σ)`,
  moved: (terms) => `Ohne sie um mehr als ihr Intervall anders: ${terms}.`,
  insteadOf: (name, without, value) => `${name} ${without} statt ${value}`,
  unmoved: "Ohne sie bleibt jeder Koeffizient in seinem Intervall.",
  leaveOut: "Weglassen",
  leaveAllOut: "Alle weglassen",
  takeBack: "Wieder aufnehmen",
  reasonOut: (nodes) => `Weggelassen: ${nodes}`,
  reasonBack: (nodes) => `Wieder aufgenommen: ${nodes}`,
  done: "Neu angepasst; diese Anpassung gilt jetzt.",
};
