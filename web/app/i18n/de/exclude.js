/** @type {typeof import("../en/exclude.js").default} */
export default {
  suspected: "Mögliche Ausreißer",
  excluded: "Ausgeschlossen",
  about: (count) =>
    count === 1
      ? "Ein Knoten weicht stärker von den übrigen ab, als es das Rauschen erklärt."
      : `${count} Knoten weichen stärker von den übrigen ab, als es das Rauschen erklärt.`,
  heavyTails: "Oder die Fehlerverteilung hat breite Ränder: zum Vergleich mit dem Schätzer m_estimator anpassen.",
  check: "Vor dem Ausschließen dort Teil und Taster prüfen. Der Verlauf hält Ausschlüsse fest.",
  node: (place) => `Knoten ${place}`,
  cell: (row, column) => `Zeile ${row}, Spalte ${column}`,
  off: (by, sigmas) => `um ${by} abweichend (${sigmas} σ)`,
  moved: (terms) => `Ohne sie ändern sich diese Koeffizienten um mehr als ihr Intervall: ${terms}.`,
  insteadOf: (name, without, value) => `${name} ${without} statt ${value}`,
  unmoved: "Ohne sie bleibt jeder Koeffizient in seinem Intervall.",
  leaveOut: "Ausschließen",
  leaveAllOut: "Alle ausschließen",
  takeBack: "Wieder aufnehmen",
  reasonOut: (nodes) => `Ausgeschlossen: ${nodes}`,
  reasonBack: (nodes) => `Wieder aufgenommen: ${nodes}`,
  done: "Neu angepasst; diese Anpassung gilt jetzt.",
};
