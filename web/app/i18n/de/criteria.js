/** @type {import("../i18n.js").Same<typeof import("../en/criteria.js").default>} */
export default {
  min_mse: "kleinster vorhergesagter mittlerer quadratischer Fehler",
  min_condition: "kleinste Konditionszahl",
  gcv: "verallgemeinerte Kreuzvalidierung",
  discrepancy: "Diskrepanzprinzip",
  l_curve: "Ecke der L-Kurve",
  hkb: "Hoerl, Kennard und Baldwin",
  hkb_1975: "Hoerl, Kennard und Baldwin 1975",
  lawless_wang: "Lawless und Wang",
  optimal: "optimales Gewicht",
  reml: "eingeschränkte Maximum-Likelihood",
  press: "vorhergesagte Residuenquadratsumme",
  blocked_cv: "blockweise Kreuzvalidierung",
  sure: "Steins erwartungstreue Risikoschätzung",
  fixed: "vorgegebener Wert",
  least_squares: "kleinste Quadrate",
  none: "nicht regularisiert",
};
