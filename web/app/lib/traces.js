// Measured traces as they are drawn: places in mm, deviations in µm. Pure.

import { heightAt } from "./requirements.js";

/** @typedef {import("../api/client.js").Schema<"GearTrace">} GearTrace */
/** @typedef {import("../api/client.js").Schema<"EvaluatedTrace">} EvaluatedTrace */
/** @typedef {import("../api/client.js").Schema<"EvaluationSettings">} EvaluationSettings */
/** @typedef {import("../api/client.js").Schema<"Gear">} Gear */
/** @typedef {import("../api/client.js").Schema<"KBand">} KBand */
/** @typedef {{ at: number, value: number | null, design: number, inside: boolean }} Sample */
/**
 * @typedef {object} Sheet a trace to be drawn
 * @property {readonly Sample[]} samples
 * @property {readonly [number, number] | undefined} range
 * @property {Point[]} mean the mean line; none where it is not known
 * @property {Point[]} parabola the mean parabola, likewise
 */
/** @typedef {{ at: number, value: number }} Point */
/**
 * A band as it is drawn over a trace.
 * @typedef {object} DrawnBand
 * @property {readonly Point[]} upper
 * @property {readonly Point[]} lower
 * @property {readonly { low: number | undefined, high: number | undefined }[]} limits at each sample
 * @property {boolean} required by the job or the request; else hung from the highest point
 */

/** @param {number | undefined} degrees @param {number} otherwise */
const radians = (degrees, otherwise) => ((degrees ?? otherwise) * Math.PI) / 180;

/** @param {Gear} gear */
function baseRadius(gear) {
  const [beta, alpha] = [radians(gear.helix_angle_deg, 0), radians(gear.normal_pressure_angle_deg, 20)];
  const diameter = (gear.teeth * gear.normal_module_mm) / Math.cos(beta);
  return (diameter * Math.cos(Math.atan(Math.tan(alpha) / Math.cos(beta)))) / 2;
}

/** Returns the roll length at a diameter. @param {Gear} gear @param {number} diameter */
export function rollLength(gear, diameter) {
  return Math.sqrt(Math.max(0, (diameter / 2) ** 2 - baseRadius(gear) ** 2));
}

/**
 * Returns the factor from transverse heights of material to posted deviations.
 * @param {EvaluationSettings} settings @param {GearTrace} trace @param {Gear} gear
 */
export function asPosted({ sign = "din", deviation_sign, direction = "transverse" }, { kind, flank }, gear) {
  const side = flank === "left" ? 1 : -1;
  const given = deviation_sign ?? (sign === "din" ? "din" : "material");
  const signed = given === "clockwise" ? -side : given === "din" && kind === "helix" ? side : 1;
  const [beta, alpha] = [radians(gear.helix_angle_deg, 0), radians(gear.normal_pressure_angle_deg, 20)];
  const base = Math.asin(Math.sin(beta) * Math.cos(alpha));
  return direction === "normal" ? signed * Math.cos(base) : signed;
}

/**
 * @param {GearTrace} trace @param {EvaluatedTrace} evaluated @param {EvaluationSettings} settings @param {Gear | undefined} gear
 * @returns {Sheet}
 */
export function sheetOf(trace, evaluated, settings, gear) {
  const profile = trace.kind === "profile";
  const rolled = (/** @type {number} */ diameter) => (gear ? rollLength(gear, diameter) : diameter);
  const places = profile ? (trace.roll_length_mm ?? (trace.diameter_mm ?? []).map(rolled)) : (trace.z_mm ?? []);
  const requested = profile ? settings.profile_diameter_range_mm?.map(rolled) : settings.helix_range_mm;
  const ends = evaluated.range_mm ?? requested;
  const range = ends && /** @type {[number, number]} */ ([...ends].sort((a, b) => a - b));
  const line = settings.against === "involute" ? undefined : designOf(trace, evaluated);
  const samples = places.map((at, i) => {
    const value = trace.valid?.[i] === false ? null : (trace.deviation_um[i] ?? null);
    const within = !range || (at >= range[0] - 1e-9 && at <= range[1] + 1e-9);
    return { at, value, design: line?.[i] ?? 0, inside: within };
  });
  const curve = (/** @type {readonly number[] | undefined} */ heights) =>
    heights && range ? aboutDesign(heights, range, samples) : [];
  return { samples, range, mean: curve(evaluated.mean_line_um), parabola: curve(evaluated.mean_parabola_um) };
}

/** The design line of a trace. @param {GearTrace} trace @param {EvaluatedTrace} evaluated */
const designOf = (trace, evaluated) => evaluated.design_um ?? trace.design_um;

const PARABOLA_STEPS = 24;

/**
 * Returns a mean line by its ends, or a mean parabola by its ends and its middle, drawn over the
 * design line.
 * @param {readonly number[]} heights @param {readonly [number, number]} range @param {readonly Sample[]} samples @returns {Point[]}
 */
function aboutDesign(heights, [low, high], samples) {
  const [first = 0, second = 0, third] = heights;
  const [end, middle] = third === undefined ? [second, (first + second) / 2] : [third, second];
  const height = (/** @type {number} */ at) => {
    const t = (2 * (at - low)) / (high - low) - 1;
    return middle + ((end - first) / 2) * t + ((first + end) / 2 - middle) * t * t;
  };
  const design = samples.map(({ at, design: value }) => [at, value]).sort(([a = 0], [b = 0]) => a - b);
  const plain = design.every(([, value]) => value === 0);
  const even = third === undefined ? 1 : PARABOLA_STEPS;
  const places = plain
    ? Array.from({ length: even + 1 }, (_, i) => low + ((high - low) * i) / even)
    : samples.flatMap(({ at, inside }) => (inside ? [at] : []));
  return places.map((at) => ({ at, value: height(at) + (plain ? 0 : (heightAt(design, at) ?? 0)) }));
}

/** Returns the band that hangs from the highest point within the range: the distance of its upper edge from the design. @param {Sheet} sheet */
export function highest({ samples }) {
  const heights = samples.flatMap(({ value, design, inside }) => (value === null || !inside ? [] : [value - design]));
  return heights.length > 0 ? Math.max(...heights) : undefined;
}

/** A band of one width about the design, hung from the highest point. @param {Sheet} sheet @param {number} width @returns {DrawnBand[]} */
export function hangingBand(sheet, width) {
  const top = highest(sheet);
  const used = sheet.samples.filter(({ inside }) => inside);
  if (top === undefined || used.length < 2) return [];
  const edge = (/** @type {number} */ below) => used.map(({ at, design }) => ({ at, value: design + top - below }));
  const limits = sheet.samples.map(({ design, inside }) => ({
    low: inside ? design + top - width : undefined,
    high: undefined,
  }));
  return [{ upper: edge(0), lower: edge(width), limits, required: false }];
}

/**
 * Returns the required bands of a trace, shifted to fit it best.
 * @param {Sheet} sheet @param {GearTrace} trace @param {EvaluatedTrace} evaluated @param {EvaluationSettings} settings @param {Gear} gear
 * @returns {DrawnBand[]}
 */
export function requiredBands(sheet, trace, evaluated, settings, gear) {
  const factor = asPosted(settings, trace, gear);
  return (evaluated.k_bands ?? []).flatMap(({ band: index, shift_um: shift }) => {
    const band = settings.k_bands?.[index];
    if (!band) return [];
    const line = (/** @type {readonly number[][]} */ points) =>
      points.map(([at = 0, value = 0]) => [placeOf(band, gear, at), factor * (value - shift)]);
    const [upper, lower] = factor > 0 ? [line(band.upper), line(band.lower)] : [line(band.lower), line(band.upper)];
    const design = band.against === "design" ? designOf(trace, evaluated) : undefined;
    const about = (/** @type {readonly number[][]} */ points, /** @type {number} */ at, /** @type {number} */ i) => {
      const height = heightAt(points, at);
      return height === undefined ? undefined : height + (design?.[i] ?? 0);
    };
    const limits = sheet.samples.map(({ at }, i) => ({ low: about(lower, at, i), high: about(upper, at, i) }));
    // a line about the design is bent between its points
    const drawn = (/** @type {readonly number[][]} */ points, /** @type {"low" | "high"} */ edge) =>
      design
        ? sheet.samples
            .flatMap(({ at }, i) => {
              const value = limits[i]?.[edge];
              return value === undefined ? [] : [{ at, value }];
            })
            .sort((a, b) => a.at - b.at)
        : points.map(([at = 0, value = 0]) => ({ at, value }));
    return [{ upper: drawn(upper, "high"), lower: drawn(lower, "low"), limits, required: true }];
  });
}

/** Returns a place of a band in the unit of charts: roll lengths, or z. @param {KBand} band @param {Gear} gear @param {number} at */
function placeOf({ kind, profile_axis: axis }, gear, at) {
  if (kind === "helix" || axis === undefined || axis === "roll_length") return at;
  return axis === "diameter" ? rollLength(gear, at) : baseRadius(gear) * radians(at, 0);
}

/** Returns the distance of a sample from a band: negative below it; 0 within. @param {Sample} sample @param {DrawnBand["limits"][number] | undefined} limits */
export function outsideBy({ value }, limits) {
  if (value === null || !limits) return 0;
  if (limits.low !== undefined && value < limits.low - 1e-9) return value - limits.low;
  return limits.high !== undefined && value > limits.high + 1e-9 ? value - limits.high : 0;
}

const STEPS = [1, 10, 100, 1000, 10000].flatMap((power) => [1, 2, 3, 4, 5, 8].map((step) => step * power));

/** Returns the greatest usual magnification at which a length still fits. @param {number} size mm @param {number} space mm */
export function magnification(size, space) {
  return STEPS.findLast((step) => step * size <= space) ?? 1;
}
