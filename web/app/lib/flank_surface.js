// The request for slopes, crownings and twist of nodes that belong to no job. Pure.

import { micrometres, MICROMETRES } from "./units.js";

/** @typedef {import("../api/client.js").Schema<"FlankSurfaceRequest">} FlankSurfaceRequest */
/** @typedef {import("../api/client.js").Schema<"Axes">} Axes */
/** @typedef {import("../api/client.js").Schema<"Gear">} Gear */
/** @typedef {import("../api/client.js").Schema<"Nodes">} Nodes */

/** Members of a fit that mean the same for a surface over roll length and face width in mm. */
const SHARED = ["scaling", "estimator", "errors", "level"];
/** Members that do not affect the fitted surface, or are converted. */
const READ = ["nodes", "model", "include", "flank", "tooth", "axes", "regularization", "noise_sigma", "accept_units"];
/** Regularisations without values of single coefficients. */
const PLAIN = ["none", "spectral", "ridge"];

/** Returns true if nodes lie over roll length, roll angle or diameter and face width, with heights in a known unit. @param {Nodes} nodes @param {Axes | undefined} axes */
export function isOverFlank(nodes, axes) {
  const across = axes?.v?.quantity === "face_width" && MICROMETRES[axes.v.unit ?? ""] !== undefined;
  const surface = nodes.type === "grid" || nodes.type === "scattered";
  return surface && across && profileOf(axes?.u) !== undefined && micrometres(axes) !== undefined;
}

/** Returns true if a fit has what the request does not support, such as filters or unequal weights. @param {Nodes} nodes @param {Axes | undefined} axes @param {Record<string, unknown>} spec */
export function hasMore(nodes, axes, spec) {
  const { type = "spectral" } = /** @type {{ type?: string }} */ (spec["regularization"] ?? {});
  const known = Object.keys(spec).every((name) => SHARED.includes(name) || READ.includes(name));
  const given = /** @type {{ weight?: readonly (number | readonly number[])[] | null }} */ (nodes).weight;
  const weights = new Set((given ?? []).flat().filter((weight) => weight > 0));
  return !known || !PLAIN.includes(type) || Boolean(axes?.z?.trace_lengths) || weights.size > 1;
}

/**
 * Returns the request; undefined if the axes are no flank's, or if the fit has conditions that the
 * request does not support.
 * @param {Nodes} nodes
 * @param {{ axes: Axes | undefined, flank: "left" | "right", gear: Gear, spec: Record<string, unknown> }} of
 * @returns {FlankSurfaceRequest | undefined}
 */
export function flankSurfaceRequest(nodes, { axes, flank, gear, spec }) {
  const { regularization = { type: "spectral" }, noise_sigma: noise } = /** @type {any} */ (spec);
  const height = micrometres(axes);
  const profile = profileOf(axes?.u);
  const width = MICROMETRES[axes?.v?.unit ?? ""];
  if (nodes.type !== "grid" && nodes.type !== "scattered") return undefined;
  if (!isOverFlank(nodes, axes) || hasMore(nodes, axes, spec)) return undefined;
  if (height === undefined || !profile || width === undefined) return undefined;
  const counted = (/** @type {number | null | undefined} */ z, /** @type {number | undefined} */ weight = 1) =>
    typeof z === "number" && weight > 0 ? z * height : null;
  const deviations =
    nodes.type === "grid"
      ? nodes.z.map((row, i) =>
          row.map((z, j) => (nodes.valid?.[i]?.[j] === false ? null : counted(z, nodes.weight?.[i]?.[j]))),
        )
      : nodes.z.map((z, i) => counted(z, nodes.weight?.[i]));
  return {
    ...Object.fromEntries(SHARED.flatMap((name) => (name in spec ? [[name, spec[name]]] : []))),
    regularization,
    ...(typeof noise === "number" ? { noise_sigma: noise * Math.abs(height) } : {}),
    ...(spec["accept_units"] === true ? { accept_units: true } : {}),
    gear,
    flank,
    profile_axis: profile.axis,
    profile: nodes.u.map((u) => u * profile.factor),
    z_mm: nodes.v.map((v) => (v * width) / 1000),
    deviation_um: deviations,
  };
}

/** @param {import("../api/client.js").Schema<"Axis"> | null | undefined} axis @returns {{ axis: "roll_length" | "roll_angle" | "diameter", factor: number } | undefined} */
function profileOf(axis) {
  const degrees = /** @type {Record<string, number>} */ ({ deg: 1, arcmin: 1 / 60 })[axis?.unit ?? ""];
  if (axis?.quantity === "roll_length" && degrees !== undefined) return { axis: "roll_angle", factor: degrees };
  const length = MICROMETRES[axis?.unit ?? ""];
  if (length === undefined || (axis?.quantity !== "roll_length" && axis?.quantity !== "diameter")) return undefined;
  return { axis: axis.quantity, factor: length / 1000 };
}

/** Returns true if a model is the surface of second order itself, so that its fit has the same figures. @param {unknown} model */
export function isSecondOrder(model) {
  const { type, degree, terms } = /** @type {{ type?: string, degree?: number | number[], terms?: string }} */ (
    model ?? {}
  );
  return type === "polynomial" && terms === "total" && [degree].flat().every((one) => one === 2);
}
