// Measured traces as they are drawn: places in mm, deviations in µm. Pure.

/** @typedef {import("../api/client.js").Schema<"GearTrace">} GearTrace */
/** @typedef {import("../api/client.js").Schema<"EvaluatedTrace">} EvaluatedTrace */
/** @typedef {import("../api/client.js").Schema<"EvaluationSettings">} EvaluationSettings */
/** @typedef {import("../api/client.js").Schema<"Gear">} Gear */
/** @typedef {{ at: number, value: number | null, design: number, inside: boolean }} Sample */
/**
 * @typedef {object} Sheet a trace to be drawn
 * @property {readonly Sample[]} samples
 * @property {readonly [number, number] | undefined} range
 * @property {{ at: number, value: number }[]} mean ends of the mean line; none where it is not known
 */

/** The roll length at a diameter. @param {Gear} gear @param {number} diameter */
export function rollLength(gear, diameter) {
  const beta = ((gear.helix_angle_deg ?? 0) * Math.PI) / 180;
  const alpha = ((gear.normal_pressure_angle_deg ?? 20) * Math.PI) / 180;
  const base =
    ((gear.teeth * gear.normal_module_mm) / Math.cos(beta)) * Math.cos(Math.atan(Math.tan(alpha) / Math.cos(beta)));
  return Math.sqrt(Math.max(0, diameter * diameter - base * base)) / 2;
}

/**
 * Whether slopes are answered in the sign of the posted deviations.
 * @param {EvaluationSettings} settings
 */
export function sameSign({ sign = "din", deviation_sign, direction = "transverse" }) {
  if (direction !== "transverse") return false;
  return sign === "as_given" || (sign === "din" && (deviation_sign ?? "din") === "din");
}

/** @param {GearTrace} trace @param {EvaluatedTrace} evaluated @param {EvaluationSettings} settings @param {Gear | undefined} gear @returns {Sheet} */
export function sheetOf(trace, evaluated, settings, gear) {
  const profile = trace.kind === "profile";
  const rolled = (/** @type {number} */ diameter) => (gear ? rollLength(gear, diameter) : diameter);
  const places = profile ? (trace.roll_length_mm ?? (trace.diameter_mm ?? []).map(rolled)) : (trace.z_mm ?? []);
  const told = profile ? settings.profile_diameter_range_mm?.map(rolled) : settings.helix_range_mm;
  const range = told && /** @type {[number, number]} */ ([...told].sort((a, b) => a - b));
  const samples = places.map((at, i) => {
    const value = trace.valid?.[i] === false ? null : (trace.deviation_um[i] ?? null);
    const within = !range || (at >= range[0] - 1e-9 && at <= range[1] + 1e-9);
    return { at, value, design: trace.design_um?.[i] ?? 0, inside: within };
  });
  return { samples, range, mean: sameSign(settings) ? meanLine(samples, range, trace, evaluated, settings, gear) : [] };
}

/** The line of the answered slope through the mean of the samples, about the design. @param {readonly Sample[]} samples @param {readonly [number, number] | undefined} range @param {GearTrace} trace @param {EvaluatedTrace} evaluated @param {EvaluationSettings} settings @param {Gear | undefined} gear */
function meanLine(samples, range, trace, evaluated, settings, gear) {
  const used = samples.filter(({ value, inside }) => value !== null && inside);
  const own = range ? range[1] - range[0] : undefined;
  const length =
    trace.kind === "profile"
      ? (settings.profile_reference_length_mm ?? (settings.profile_reference === "to_tip" ? undefined : own))
      : (settings.helix_reference_length_mm ??
        (settings.helix_reference === "evaluation_range" ? own : (gear?.face_width_mm ?? undefined)));
  const { slope_um: slope } = evaluated;
  if (!range || !length || typeof slope !== "number" || used.length < 2 || trace.design_um) return [];
  const middle = used.reduce((sum, { at }) => sum + at, 0) / used.length;
  const level = used.reduce((sum, { value }) => sum + (value ?? 0), 0) / used.length;
  return range.map((at) => ({ at, value: level + (slope * (at - middle)) / length }));
}

/** The band that hangs from the highest point within the range: how far its upper edge is above the design. @param {Sheet} sheet */
export function highest({ samples }) {
  const heights = samples.flatMap(({ value, design, inside }) => (value === null || !inside ? [] : [value - design]));
  return heights.length > 0 ? Math.max(...heights) : undefined;
}

/** Whether a sample lies outside of a band of this width. @param {Sample} sample @param {number} top @param {number} width */
export function isOutside({ value, design, inside }, top, width) {
  return value !== null && inside && value - design < top - width - 1e-9;
}

const STEPS = [1, 10, 100, 1000, 10000].flatMap((power) => [1, 2, 3, 4, 5, 8].map((step) => step * power));

/** The greatest usual magnification at which a length still fits. @param {number} size mm @param {number} room mm */
export function magnification(size, room) {
  return STEPS.findLast((step) => step * size <= room) ?? 1;
}
