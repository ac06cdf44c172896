// The form of a gear: texts as they are typed, and the gear they describe. Pure.

import { parseNumber } from "./format.js";

/** @typedef {import("../api/client.js").Schema<"Gear">} Gear */
/** @typedef {Record<keyof typeof FIELDS | "internal", string>} GearForm */
/** @typedef {Partial<Record<keyof GearForm, "notANumber" | "notWhole" | "needed">>} GearErrors */

/** The fields, with their JSON Pointers below the gear. */
export const FIELDS = /** @type {const} */ ({
  teeth: { pointer: "/teeth", kind: "whole", required: true },
  normal_module_mm: { pointer: "/normal_module_mm", kind: "number", required: true },
  normal_pressure_angle_deg: { pointer: "/normal_pressure_angle_deg", kind: "number" },
  helix_angle_deg: { pointer: "/helix_angle_deg", kind: "number" },
  profile_shift_coefficient: { pointer: "/profile_shift_coefficient", kind: "number" },
  face_width_mm: { pointer: "/face_width_mm", kind: "number" },
  tip_diameter_mm: { pointer: "/tip_diameter_mm", kind: "number" },
  root_diameter_mm: { pointer: "/root_diameter_mm", kind: "number" },
  hand: { pointer: "/hand", kind: "text" },
  tip_radius_mm: { pointer: "/tool/tip_radius_mm", kind: "number" },
  addendum_factor: { pointer: "/tool/addendum_factor", kind: "number" },
  protuberance_mm: { pointer: "/tool/protuberance_mm", kind: "number" },
});

/**
 * Returns the form of a gear; numbers as `write` formats them.
 * @param {Gear | undefined} gear @param {(value: number) => string} write
 * @returns {GearForm}
 */
export function formOf(gear, write) {
  const form = /** @type {GearForm} */ ({ internal: gear?.internal ? "yes" : "" });
  for (const name of names()) {
    const value = valueAt(gear, FIELDS[name].pointer);
    form[name] = typeof value === "number" ? write(value) : typeof value === "string" ? value : "";
  }
  return form;
}

/**
 * Returns the gear of a form, or its errors.
 * @param {GearForm} form
 * @returns {{ gear: Gear, errors?: undefined } | { gear?: undefined, errors: GearErrors }}
 */
export function gearOf(form) {
  /** @type {GearErrors} */
  const errors = {};
  /** @type {Record<string, unknown>} */
  const gear = {};
  /** @type {Record<string, unknown>} */
  const tool = {};
  for (const name of names()) {
    const { kind, pointer, ...rest } = FIELDS[name];
    const text = form[name];
    const value = kind === "text" ? text.trim() || undefined : parseNumber(text);
    if (value === undefined) {
      if ("required" in rest) errors[name] = "needed";
      continue;
    }
    if (Number.isNaN(value)) errors[name] = "notANumber";
    else if (kind === "whole" && !Number.isInteger(value)) errors[name] = "notWhole";
    if (pointer.startsWith("/tool/")) tool[name] = value;
    else gear[name] = value;
  }
  if (form.internal) gear["internal"] = true;
  if (Object.keys(tool).length > 0) gear["tool"] = tool;
  if (Object.keys(errors).length > 0) return { errors };
  return { gear: /** @type {Gear} */ (/** @type {unknown} */ (gear)) };
}

const names = () => /** @type {(keyof typeof FIELDS)[]} */ (Object.keys(FIELDS));

/** @param {unknown} root @param {string} pointer */
function valueAt(root, pointer) {
  let value = root;
  for (const part of pointer.split("/").slice(1)) {
    value =
      typeof value === "object" && value !== null ? /** @type {Record<string, unknown>} */ (value)[part] : undefined;
  }
  return value;
}

/**
 * Reads tags from lines `name = value`.
 * @param {string} text @returns {Record<string, string> | undefined} none where a line is no tag
 */
export function tagsOf(text) {
  /** @type {Record<string, string>} */
  const tags = {};
  for (const line of text.split("\n").map((one) => one.trim())) {
    if (line === "") continue;
    const [, name, value] = /^([^=]+?)\s*=\s*(.+)$/.exec(line) ?? [];
    if (!name || !value) return undefined;
    tags[name] = value;
  }
  return tags;
}

/** @param {Record<string, string> | undefined} tags */
export function tagLines(tags) {
  const lines = Object.entries(tags ?? {}).map(([name, value]) => `${name} = ${value}`);
  return lines.join("\n");
}
