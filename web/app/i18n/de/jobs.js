/** @type {import("../i18n.js").Same<typeof import("../en/jobs.js").default>} */
export default {
  title: "Aufträge",
  about: "Neueste zuerst. Suchen, filtern und sortieren kann der Server diese Liste noch nicht.",
  caption: "Aufträge",
  name: "Auftrag",
  part: "Teilenummer",
  serial: "Seriennummer",
  machine: "Maschine",
  gear: "Zahnrad",
  tags: "Merkmale",
  created: "Angelegt",
  changed: "Letzte Änderung",
  none: "Noch gibt es keinen Auftrag. Ein Auftrag ist ein Zahnrad auf dem Weg von der ersten Messung bis zur Annahme.",
  emptyPage: "Auf dieser Seite stehen keine weiteren Aufträge.",
  older: "Ältere",
  newest: "Neueste",
  pages: "Seiten der Liste",
};
