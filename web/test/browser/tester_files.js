// Files of gear testers and of gear programs, for dropping: written here, without any reader's
// code.

const MODULE = 1;
const TEETH = 52;
const SAMPLES = 60;
const BASE = TEETH * MODULE * Math.cos((20 * Math.PI) / 180);
const roll = (/** @type {number} */ diameter) => 0.5 * Math.sqrt(diameter ** 2 - BASE ** 2);

/** @param {"MK" | "MW"} kind */
function head(kind) {
  const code = (/** @type {number} */ number, /** @type {string} */ label, /** @type {string | number} */ fields) =>
    `  ${String(number).padEnd(4)}:${label.padEnd(40, ".")}: ${fields}`;
  const pair = (/** @type {number} */ value) => `${value}      ${value}`;
  return [
    `HEADER KS.${kind}.FILE`,
    "TYPE      STI                ! Gear data",
    "VERSION   10.0 /2            ! Version",
    "SEPARATOR :                  ! Separator",
    "UNITS     mm                 ! Units",
    "ANGLE     decimal            ! Angle",
    "PROFILE   diameter           ! Profile",
    "LANGUAGE  0 DEU              ! Language",
    "UNDEFINED -2147483.648       ! Undefined",
    "",
    code(1, "Protokolldaten für Zahnrad", ""),
    code(20, "Zahnrad-Daten", "links   rechts"),
    code(21, "Normalmodul mn", `${MODULE}::L- :R-`),
    code(22, "Zähnezahl z", `${TEETH}      Außenverzahnung`),
    code(23, "Schrägungswinkel ß [Grad]", "0   "),
    code(24, "Eingriffswinkel alpha [Grad]", 20),
    code(25, "Profilverschiebungsfaktor x", ".011"),
    code(26, "Zahnbreite [mm]", 15),
    code(27, "Kopfkreisdurchmesser da", 54.0219),
    code(272, "Fußkreisdurchmesser", 49.5219),
    ...[50.156, 50.3, 54.022, 54.2, 5.552].map((value, i) => code(41 + i, "Messbereich [mm]", pair(value))),
    ...[51.898, 51, 53].map((value, i) => code([46, 48, 49][i] ?? 0, "Flankenlinienmesskreis", pair(value))),
    ...[0, 0.75, 14.25, 15].map((value, i) => code(61 + i, "Messanfang (unten)", pair(value))),
    ...[7.5, 1, 14].map((value, i) => code([65, 68, 69][i] ?? 0, "Lage des Profils", pair(value))),
    code(164, "Seitendefinition", "ZSDEF: 0"),
    code(165, "Reference fHb", " 0-VDI / 1-DIN :R_FHB: 1 : L: + : R: -"),
    code(178, "Vorzeichen Flankenlinie", "LVORZ: 1: DIN"),
    code(179, "Bezugslaenge Flankenlinie", "BZGFL: 1: Z"),
    code(180, "Bezugslaenge Profil", "BZGPR: 0: M1-M2"),
  ];
}

/** Three leads and three profiles of the left flank of tooth 1: 10 µm over the evaluated profile, 6 µm over the width. */
export function curvesFile() {
  const [from, to] = [roll(50.156), roll(54.2)];
  const tilt = (/** @type {number} */ l, /** @type {number} */ z) =>
    (10 * (l - roll(50.3))) / (roll(54.022) - roll(50.3)) + (6 * z) / 15;
  const at = (/** @type {number} */ k, /** @type {number} */ low, /** @type {number} */ high) =>
    low + ((high - low) * k) / (SAMPLES - 1);
  const lines = head("MK");
  const trace = (/** @type {string} */ title, /** @type {string} */ place, /** @type {number[]} */ values) => {
    lines.push(`${title} links / ${SAMPLES}  Werte  ${place}`);
    for (let i = 0; i < values.length; i += 12) {
      const row = values.slice(i, i + 12).map((value) => value.toFixed(3).padStart(12));
      lines.push(` ${row.join(" ")}`);
    }
    lines.push("");
  };
  const samples = (/** @type {(k: number) => number} */ of) => Array.from({ length: SAMPLES }, (_, k) => -of(k));
  for (const [letter, index, diameter] of /** @type {const} */ ([
    ["f", 1, 51],
    ["", 2, 51.898],
    ["k", 3, 53],
  ])) {
    const title = letter
      ? `Verschränkung: Zahn-Nr.: 1${letter} /Flankenlinie:${index}`
      : "Flankenlinie:\r\nZahn-Nr.: 1";
    const values = samples((k) => tilt(roll(diameter), at(k, 0, 15)));
    trace(title, `x= ${roll(diameter).toFixed(3)}`, values);
  }
  for (const [letter, index, z] of /** @type {const} */ ([
    ["u", 1, 1],
    ["", 2, 7.5],
    ["o", 3, 14],
  ])) {
    const title = letter ? `Verschränkung: Zahn-Nr.: 1${letter} /Profil:${index}` : "Profil:\r\nZahn-Nr.: 1";
    const values = samples((k) => tilt(at(k, from, to), z));
    trace(title, `z= ${z}`, values);
  }
  return `\uFEFF${lines.join("\r\n")}\r\n`;
}

/** The gear and its printed values. */
export function valuesFile() {
  return `\uFEFF${[...head("MW"), "10111 : fHb links 1          :   -2.9", "31610 : Fr : 30.1", ""].join("\r\n")}`;
}

/** A model of two gears, one of them with a topography of its left flank: 2 µm per mm of width. */
export function rexsModel() {
  const attribute = (/** @type {string} */ id, /** @type {string} */ unit, /** @type {string | number} */ value) =>
    `<attribute id="${id}" unit="${unit}">${value}</attribute>`;
  const list = (/** @type {number[]} */ values) =>
    `<array>${values.map((value) => `<c>${value}</c>`).join("")}</array>`;
  const [diameters, z] = [
    [50.5, 51.5, 52.5, 53.5],
    [1, 5, 9, 13],
  ];
  const row = `<r>${z.map((one) => `<c>${(2e-3 * one).toFixed(4)}</c>`).join("")}</r>`;
  const gear = [attribute("number_of_teeth", "none", TEETH), attribute("normal_module", "mm", MODULE)];
  return `<?xml version="1.0" encoding="UTF-8" standalone="no" ?>
<model applicationId="test" applicationVersion="1" date="2026-01-01" version="1.4">
  <relations>
    <relation id="7" type="flank">
      <ref hint="cylindrical_gear" id="7" role="gear"/><ref id="8" role="left"/><ref id="9" role="right"/>
    </relation>
  </relations>
  <components>
    <component id="7" name="wheel" type="cylindrical_gear">${gear.join("")}
      ${attribute("normal_pressure_angle", "deg", 20)}${attribute("helix_angle", "deg", 0)}
      ${attribute("addendum_modification_coefficient", "none", 0.011)}${attribute("face_width", "mm", 15)}
    </component>
    <component id="8" name="left" type="cylindrical_gear_flank">
      ${attribute("topographical_deviation_amounts", "mm", `<matrix>${diameters.map(() => row).join("")}</matrix>`)}
      ${attribute("diameters_of_topographical_deviation", "mm", list(diameters))}
      ${attribute("coordinates_of_topographical_deviation", "mm", list(z))}
    </component>
    <component id="9" name="right" type="cylindrical_gear_flank"></component>
    <component id="10" name="pinion" type="cylindrical_gear">${gear.join("")}</component>
  </components>
</model>
`;
}
