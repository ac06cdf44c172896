// Responses of the interface as surfaces.

import { gridOf, withHeights, withoutMean } from "./surface.js";
import { scatteredOf } from "./triangles.js";

/** @typedef {import("../api/client.js").Schema<"Nodes">} Nodes */
/** @typedef {import("./surface.js").FlankSurface} FlankSurface */

/** Returns the measured surface; undefined for a curve or a measurement matrix. @param {Nodes} nodes @returns {FlankSurface | undefined} */
export function surfaceOf(nodes) {
  if (nodes.type === "grid") return gridOf(nodes.u, nodes.v, nodes.z, nodes.valid);
  if (nodes.type === "scattered") return scatteredOf(nodes.u, nodes.v, nodes.z);
  return undefined;
}

/**
 * Spreads values of the counted nodes (residuals, fitted heights) over all nodes.
 * @param {FlankSurface} surface @param {readonly number[]} values
 * @param {readonly number[] | null | undefined} indices the node of each value; left out where all count
 */
export function atNodes(surface, values, indices) {
  const z = new Float64Array(surface.z.length).fill(Number.NaN);
  for (let k = 0; k < values.length; k += 1) z[indices?.[k] ?? k] = values[k] ?? Number.NaN;
  return withHeights(surface, z);
}

/** Returns the heights of all nodes in the order posted, as in corrections. @param {FlankSurface} surface @param {readonly (number | null)[]} list */
export function atAllNodes(surface, list) {
  return list.length === surface.z.length
    ? withHeights(
        surface,
        Float64Array.from(list, (value) => value ?? Number.NaN),
      )
    : undefined;
}

/**
 * Returns true if the deviations of a correction have a datum, so that their mean is measured, as
 * thickness is. Otherwise the mean is meaningless, and figures and maps ignore it.
 * @param {import("../api/client.js").Schema<"Correction">} kept
 */
export function hasDatum({ result }) {
  return result.absolute;
}

/**
 * Returns heights of a correction for drawing: minus the target, and minus their mean if they have
 * no datum.
 * @template {FlankSurface} S
 * @param {S} surface @param {import("../api/client.js").Schema<"Correction">} kept @returns {S}
 */
export function ofCorrection(surface, kept) {
  const wanted = kept.result.target.deviation_um;
  const left = wanted
    ? withHeights(
        surface,
        surface.z.map((z, k) => z - (wanted[k] ?? 0)),
      )
    : surface;
  return hasDatum(kept) ? left : withoutMean(left);
}
