// The requirements of a job, and their form: texts as they are typed. Pure.

import { parseNumber } from "./format.js";

/** @typedef {import("../api/client.js").Schema<"Requirements">} Requirements */
/** @typedef {import("../api/client.js").Schema<"ToleranceLimits">} ToleranceLimits */
/** @typedef {import("../api/client.js").Schema<"PitchLimits">} PitchLimits */
/** @typedef {import("../api/client.js").Schema<"KBand">} KBand */
/** @typedef {Record<string, number[] | undefined>} Limits */
/** @typedef {(typeof FIGURES)[number]["name"] | PitchName} FigureName */
/** @typedef {(typeof PITCH_FIGURES)[number]["name"]} PitchName */
/** @typedef {"both" | "left" | "right"} Side */
/** @typedef {{ kind: "profile" | "helix", flank: "" | "left" | "right", against: "involute" | "design", axis: "roll_length" | "diameter" | "roll_angle", upper: string, lower: string }} BandForm */
/** @typedef {"notANumber" | "twoEnds" | "order" | "points"} FieldError */
/**
 * @typedef {object} RequirementsForm
 * @property {string} class
 * @property {string} [pitchClass] of pitches and run-out, where it is another
 * @property {Record<string, string>} limits by `placeOf`; what is left empty is not there
 * @property {Record<string, string>} [design] figures of both flanks that corrections aim at, by their names
 * @property {Record<string, unknown>} [designOthers] members of a design without fields in the form
 * @property {BandForm[]} bands
 * @property {Record<string, unknown>} [others] what the form has no fields for, which stays as it is
 */

/** The classes of ISO 1328-1. */
export const CLASSES = Array.from({ length: 11 }, (_, i) => String(i + 1));

/** The figures that have limits, with their symbols. */
export const FIGURES = /** @type {const} */ ([
  { name: "profile_slope", symbol: "f_Hα" },
  { name: "helix_slope", symbol: "f_Hβ" },
  { name: "profile_crowning", symbol: "C_α" },
  { name: "helix_crowning", symbol: "C_β" },
  { name: "twist", symbol: "S" },
  { name: "profile_form", symbol: "f_fα" },
  { name: "helix_form", symbol: "f_fβ" },
  { name: "profile_total", symbol: "F_α" },
  { name: "helix_total", symbol: "F_β" },
]);

/** Figures measured around the whole gear. */
export const PITCH_FIGURES = /** @type {const} */ ([
  { name: "single_pitch", symbol: "f_p" },
  { name: "cumulative_pitch", symbol: "F_p" },
  { name: "runout", symbol: "F_r" },
]);
export const ALL_FIGURES = [...FIGURES, ...PITCH_FIGURES];

/** Figures that the surface of a fit has, too. */
export const SURFACE_FIGURES = FIGURES.slice(0, 5).map(
  ({ name, symbol }) => /** @type {{ name: SurfaceFigure, symbol: string }} */ ({ name, symbol }),
);
/** @typedef {"profile_slope" | "helix_slope" | "profile_crowning" | "helix_crowning" | "twist"} SurfaceFigure */

export const SIDES = /** @type {const} */ (["both", "left", "right"]);

/** Returns the sides of a figure's limits: the run-out belongs to both flanks. @param {FigureName} name */
export const sidesOf = (name) => (name === "runout" ? SIDES.slice(0, 1) : SIDES);

/** @param {FigureName} name */
const group = (name) =>
  PITCH_FIGURES.some((figure) => figure.name === name)
    ? /** @type {const} */ ("pitch_limits")
    : /** @type {const} */ ("tolerance_limits");

/** Returns the JSON Pointer of a limit in a request. @param {Side} side @param {FigureName} name */
export const limitPointer = (side, name) =>
  `/requirements/${group(name)}${side === "both" ? "" : `/${side}`}/${name}_um`;

/** JSON Pointer of a figure of the design in a request. @param {SurfaceFigure} name */
export const designPointer = (name) => `/requirements/design/${name}_um`;

/** Key of a figure of the design in the form. @param {SurfaceFigure} name */
export const designPlace = (name) => `design ${name}`;

/** Returns the key of a limit in the form. @param {Side} side @param {FigureName} name @param {0 | 1} end */
export const placeOf = (side, name, end) => `${side} ${name} ${end}`;

/** Returns the required limits of one figure. @param {Requirements | undefined} requirements @param {Side} side @param {FigureName} name */
export function limitsOf(requirements, side, name) {
  const all = /** @type {Limits & { left?: Limits, right?: Limits } | undefined} */ (requirements?.[group(name)]);
  const of = side === "both" ? all : all?.[side];
  const [low, high] = of?.[`${name}_um`] ?? [];
  return low === undefined || high === undefined ? undefined : /** @type {const} */ ([low, high]);
}

/**
 * Returns the required limits of a figure of a flank: its own, those of both flanks, or the
 * tolerance of the class.
 * @param {Requirements | undefined} requirements @param {"left" | "right" | undefined} flank @param {SurfaceFigure} name
 * @param {import("../api/client.js").Schema<"ToleranceValues"> | undefined} tolerances of the required class
 * @returns {readonly number[] | undefined}
 */
export function requiredLimits(requirements, flank, name, tolerances) {
  const own = flank && limitsOf(requirements, flank, name);
  const given = own ?? limitsOf(requirements, "both", name);
  if (given) return given;
  const tolerance = name === "profile_slope" || name === "helix_slope" ? tolerances?.[`${name}_um`] : undefined;
  return tolerance === undefined ? undefined : [-tolerance, tolerance];
}

/** @returns {RequirementsForm} */
export const emptyRequirements = () => ({ class: "", limits: {}, bands: [] });

/** @returns {BandForm} */
export const emptyBand = () => ({
  kind: "profile",
  flank: "",
  against: "involute",
  axis: "roll_length",
  upper: "",
  lower: "",
});

/** @param {Requirements | undefined} requirements @param {(value: number) => string} write @returns {RequirementsForm} */
export function requirementsForm(requirements, write) {
  const form = emptyRequirements();
  const { tolerance_limits: _, pitch_limits: __, k_bands: ___, design, ...others } = requirements ?? {};
  if (Object.keys(others).length > 0) form.others = others;
  form.class = String(requirements?.tolerance_limits?.class ?? "");
  form.pitchClass = String(requirements?.pitch_limits?.class ?? "");
  for (const side of SIDES)
    for (const { name } of ALL_FIGURES) {
      const limits = limitsOf(requirements, side, name);
      if (!limits) continue;
      form.limits[placeOf(side, name, 0)] = write(limits[0]);
      form.limits[placeOf(side, name, 1)] = write(limits[1]);
    }
  for (const { name } of SURFACE_FIGURES) {
    const figure = design?.[`${name}_um`];
    if (typeof figure === "number") form.design = { ...form.design, [name]: write(figure) };
  }
  const more = Object.entries(design ?? {}).filter(
    ([key]) => !SURFACE_FIGURES.some(({ name }) => key === `${name}_um`),
  );
  // a design without figures is the unmodified flank
  if (more.length > 0 || (design && !form.design)) form.designOthers = Object.fromEntries(more);
  const lines = (/** @type {readonly number[][]} */ points) =>
    points.map((point) => point.map(write).join("  ")).join("\n");
  form.bands = (requirements?.k_bands ?? []).map(({ kind, flank, against, profile_axis: axis, upper, lower }) => ({
    kind,
    flank: flank ?? "",
    against: against ?? "involute",
    axis: axis ?? "roll_length",
    upper: lines(upper),
    lower: lines(lower),
  }));
  return form;
}

/**
 * Returns the requirements of a form, if there are any. Errors by `placeOf` of the lower end, or by
 * `bandPlace`.
 * @param {RequirementsForm} form @returns {{ requirements: Requirements | undefined, errors: Record<string, FieldError> }}
 */
export function requirementsOf(form) {
  /** @type {Record<string, FieldError>} */
  const errors = {};
  const limits = limitsIn(form, form.class, FIGURES, errors);
  const pitches = limitsIn(form, form.pitchClass, PITCH_FIGURES, errors);
  const bands = form.bands.map(({ kind, flank, against, axis, ...edges }, i) => {
    const [upper, lower] = [pointsOf(edges.upper), pointsOf(edges.lower)];
    if (!upper) errors[bandPlace(i, "upper")] = "points";
    if (!lower) errors[bandPlace(i, "lower")] = "points";
    const more = {
      ...(flank ? { flank } : {}),
      ...(against === "design" ? { against } : {}),
      ...(kind === "profile" ? { profile_axis: axis } : {}),
    };
    return { kind, ...more, upper: upper ?? [], lower: lower ?? [] };
  });
  const design = designIn(form, errors);
  const whole = {
    ...form.others,
    ...(design ? { design } : {}),
    ...(limits ? { tolerance_limits: /** @type {ToleranceLimits} */ (limits) } : {}),
    ...(pitches ? { pitch_limits: /** @type {PitchLimits} */ (pitches) } : {}),
    ...(bands.length > 0 ? { k_bands: /** @type {KBand[]} */ (bands) } : {}),
  };
  return { requirements: Object.keys(whole).length > 0 ? whole : undefined, errors };
}

/**
 * Returns the limits of some figures for a request, if there are any.
 * @param {RequirementsForm} form @param {string | undefined} of their class @param {readonly { name: FigureName }[]} figures
 * @param {Record<string, FieldError>} errors to which those found are added @returns {Record<string, unknown> | undefined}
 */
function limitsIn(form, of, figures, errors) {
  /** @type {Record<string, unknown>} */
  const limits = of ? { class: Number(of) } : {};
  for (const side of SIDES) {
    /** @type {Record<string, readonly number[]>} */
    const own = {};
    for (const { name } of figures) {
      const found = endsOf(form, side, name);
      if (typeof found === "string") errors[placeOf(side, name, 0)] = found;
      else if (found) own[`${name}_um`] = found;
    }
    if (side === "both") Object.assign(limits, own);
    else if (Object.keys(own).length > 0) limits[side] = own;
  }
  return Object.keys(limits).length > 0 ? limits : undefined;
}

/** @param {number} i @param {"upper" | "lower"} edge */
export const bandPlace = (i, edge) => `band ${i} ${edge}`;

/** @param {RequirementsForm} form @param {Side} side @param {FigureName} name @returns {readonly number[] | FieldError | undefined} */
function endsOf({ limits }, side, name) {
  const [low, high] = [0, 1].map((end) => parseNumber(limits[placeOf(side, name, /** @type {0 | 1} */ (end))] ?? ""));
  if (low === undefined && high === undefined) return undefined;
  if (Number.isNaN(low) || Number.isNaN(high)) return "notANumber";
  if (low === undefined || high === undefined) return "twoEnds";
  return low <= high ? [low, high] : "order";
}

/**
 * Reads points from lines `place deviation`, places ascending; undefined if they are no line.
 * @param {string} text @returns {number[][] | undefined}
 */
export function pointsOf(text) {
  const lines = text.split("\n").filter((line) => line.trim() !== "");
  const points = lines.map((line) =>
    line
      .trim()
      .split(/[\s;]+/)
      .map(parseNumber),
  );
  const whole = points.every(([at, value, ...more]) => isNumber(at) && isNumber(value) && more.length === 0);
  const found = /** @type {number[][]} */ (points);
  if (!whole || found.length < 2) return undefined;
  return found.every(([at = 0], i) => i === 0 || at > (found[i - 1]?.[0] ?? 0)) ? found : undefined;
}

/** @param {number | undefined} value */
const isNumber = (value) => value !== undefined && Number.isFinite(value);

/**
 * Returns the design of a form: its figures of both flanks, and the members without fields.
 * @param {RequirementsForm} form @param {Record<string, FieldError>} errors
 */
function designIn(form, errors) {
  /** @type {Record<string, unknown>} */
  const design = { ...form.designOthers };
  for (const { name } of SURFACE_FIGURES) {
    const value = parseNumber(form.design?.[name] ?? "");
    if (value === undefined) continue;
    if (Number.isNaN(value)) errors[designPlace(name)] = "notANumber";
    design[`${name}_um`] = value;
  }
  return Object.keys(design).length > 0 || form.designOthers ? design : undefined;
}

/**
 * Applies the changes from one form to another to a third.
 * @param {RequirementsForm} mine @param {RequirementsForm} from @param {RequirementsForm} theirs @returns {RequirementsForm}
 */
export function requirementsRebased(mine, from, theirs) {
  /** @type {Record<string, string>} */
  const limits = {};
  for (const place of new Set([...Object.keys(mine.limits), ...Object.keys(theirs.limits)])) {
    const [own = "", begun = ""] = [mine.limits[place], from.limits[place]];
    const value = own === begun ? theirs.limits[place] : own;
    if (value) limits[place] = value;
  }
  /** @type {Record<string, string>} */
  const design = {};
  for (const { name } of SURFACE_FIGURES) {
    const [own = "", begun = ""] = [mine.design?.[name], from.design?.[name]];
    const value = own === begun ? theirs.design?.[name] : own;
    if (value) design[name] = value;
  }
  const bandsTouched = JSON.stringify(mine.bands) !== JSON.stringify(from.bands);
  return {
    class: mine.class === from.class ? theirs.class : mine.class,
    pitchClass: mine.pitchClass === from.pitchClass ? (theirs.pitchClass ?? "") : (mine.pitchClass ?? ""),
    limits,
    ...(Object.keys(design).length > 0 ? { design } : {}),
    ...(theirs.designOthers ? { designOthers: theirs.designOthers } : {}),
    bands: bandsTouched ? mine.bands : theirs.bands,
    ...(theirs.others ? { others: theirs.others } : {}),
  };
}

/** Returns the height of a line at a place; undefined outside its ends. @param {readonly number[][]} points @param {number} x */
export function heightAt(points, x) {
  const i = points.findLastIndex(([at = 0]) => at <= x);
  const [from, to] = [points[i], points[i + 1]];
  if (!from) return undefined;
  const [a = 0, low = 0] = from;
  if (!to) return x === a ? low : undefined;
  const [b = 1, high = 0] = to;
  return low + ((high - low) * (x - a)) / (b - a);
}
