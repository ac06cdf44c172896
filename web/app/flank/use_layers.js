// The layers of an iteration's map, each loaded when it is shown.

import { answer, api } from "../api/client.js";
import { useResource } from "../api/resource.js";
import { turn } from "../lib/turn.js";
import { micrometres } from "../lib/units.js";
import { useMemo, useRef } from "../../vendor/ui.js";
import { atNodes, atAllNodes, ofCorrection, surfaceOf } from "./layers.js";
import { scaleFor } from "./scale.js";
import { difference, extremesOf, withHeights } from "./surface.js";

/** @typedef {import("./surface.js").FlankSurface} FlankSurface */
/** @typedef {import("../api/client.js").Schema<"Nodes">} Nodes */
/** @typedef {import("../api/client.js").Schema<"FitResult">} FitResult */

export const LAYERS = /** @type {const} */ ([
  "measured",
  "from_design",
  "fitted",
  "residual",
  "difference",
  "predicted",
  "answered",
  "teeth",
]);
/** @typedef {(typeof LAYERS)[number]} LayerName */

/** Surfaces already made of nodes. @type {WeakMap<Nodes, FlankSurface | undefined>} */
const surfaces = new WeakMap();

/** Returns the surface of nodes requested here. @param {Nodes} nodes */
export function kept(nodes) {
  return surfaces.has(nodes) ? surfaces.get(nodes) : surfaceOf(nodes);
}

/** Returns the nodes of an iteration, as they were posted. @param {string} jobId @param {number | null} number null: of none */
export function useNodes(jobId, number) {
  return useResource(number === null ? null : `nodes ${jobId} ${number}`, async (signal) => {
    const params = { path: { job_id: jobId, number: number ?? 0 } };
    const headers = { accept: "application/json" };
    const { data, etag } = await answer(
      api.GET("/v1/jobs/{job_id}/iterations/{number}/nodes", { signal, params, headers }),
    );
    const nodes = /** @type {Nodes} */ (data);
    // many nodes are read, converted and drawn in separate tasks, between which the page stays
    // responsive
    await turn();
    const surface = surfaceOf(nodes);
    surfaces.set(nodes, surface);
    if (surface) {
      await turn();
      scaleFor(surface);
      await turn();
      extremesOf(surface);
    }
    await turn();
    return { data: nodes, etag };
  });
}

/** Number of last iterations of a job that share a scale. */
const SHARED = 8;

/**
 * Returns the common limit of the measured maps of a job, so that they can be compared.
 * @param {string} jobId @param {readonly number[]} numbers of the iterations whose heights have one unit
 */
export function useJobLimit(jobId, numbers) {
  const last = numbers.slice(-SHARED);
  const key = last.length < 2 ? null : `scale ${jobId} ${last.join(",")}`;
  const scale = useResource(key, async (signal) => {
    const limits = last.map(async (number) => {
      const params = { path: { job_id: jobId, number } };
      const headers = { accept: "application/json" };
      const { data } = await answer(
        api.GET("/v1/jobs/{job_id}/iterations/{number}/nodes", { signal, params, headers }),
      );
      const surface = surfaceOf(/** @type {Nodes} */ (data));
      return surface ? scaleFor(surface).limit : 0;
    });
    return { data: Math.max(...(await Promise.all(limits))) };
  });
  // a new iteration was added: the map keeps its scale until the new one is known
  const known = useRef(/** @type {number | undefined} */ (undefined));
  if (scale.data !== undefined) known.current = scale.data;
  const limit = key === null ? 0 : known.current;
  return { limit: limit ?? 0, ready: limit !== undefined || scale.error !== undefined };
}

/**
 * Returns a fit of an iteration in full.
 * @param {string} jobId @param {number} number @param {string | undefined} fitId none: nothing is requested
 * @param {readonly import("../api/client.js").Schema<"FitInclude">[]} [include]
 */
export function useFit(jobId, number, fitId, include = []) {
  const key = fitId === undefined ? null : `fit ${jobId} ${number} ${fitId} ${include.join(",")}`;
  return useResource(key, (signal) =>
    answer(
      api.GET("/v1/jobs/{job_id}/iterations/{number}/fits/{fit_id}", {
        signal,
        params: {
          path: { job_id: jobId, number, fit_id: fitId ?? "" },
          query: include.length > 0 ? { include: [...include] } : {},
        },
      }),
    ),
  );
}

/** Returns the correction of an iteration with its nodes. @param {string} jobId @param {number} number @param {boolean} wanted */
function useCorrection(jobId, number, wanted) {
  return useResource(wanted ? `correction ${jobId} ${number} nodes` : null, async (signal) => {
    const params = { path: { job_id: jobId, number }, query: { include: /** @type {["nodes"]} */ (["nodes"]) } };
    const headers = { accept: "application/json" };
    const { data, etag } = await answer(
      api.GET("/v1/jobs/{job_id}/iterations/{number}/correction", { signal, params, headers }),
    );
    return { data: /** @type {import("../api/client.js").Schema<"Correction">} */ (data), etag };
  });
}

/**
 * Returns the design at the nodes of an iteration.
 * @param {string} jobId @param {number} number @param {string | undefined} measured measurand of the nodes; none: nothing is requested
 */
function useDesign(jobId, number, measured) {
  return useResource(measured === undefined ? null : `design ${jobId} ${number} ${measured}`, (signal) =>
    answer(
      api.GET("/v1/jobs/{job_id}/iterations/{number}/design", { signal, params: { path: { job_id: jobId, number } } }),
    ),
  );
}

/**
 * Returns the surface of a layer, as soon as all of its data is there.
 * @param {{ jobId: string, number: number, fitId: string | undefined, layer: LayerName, other: number | undefined, corrected: boolean,
 *   measurand: { flank?: string | null | undefined, axes?: import("../lib/units.js").Axes | null | undefined } }} of
 *   `other`: the iteration of the difference; `measurand`: what the nodes are of; `corrected`: there is a correction; all teeth are no layer of the nodes
 */
export function useLayer({ jobId, number, fitId, layer, other, corrected, measurand: { flank, axes } }) {
  const nodes = useNodes(jobId, number);
  const ofFit = layer === "fitted" || layer === "residual";
  const fit = useFit(jobId, number, ofFit ? fitId : undefined, layer === "fitted" ? ["fitted"] : ["residuals"]);
  const before = useNodes(jobId, layer === "difference" && other !== undefined ? other : null);
  const ofCorrection = (layer === "predicted" || layer === "answered") && corrected;
  const correction = useCorrection(jobId, number, ofCorrection);
  const fromDesign = layer === "from_design";
  const design = useDesign(jobId, number, fromDesign ? JSON.stringify([flank, axes]) : undefined);
  const factor = micrometres(axes);
  const measured = useMemo(() => (nodes.data ? kept(nodes.data) : undefined), [nodes.data]);
  const earlier = useMemo(() => (before.data ? kept(before.data) : undefined), [before.data]);
  const made = useMemo(
    () =>
      measured
        ? fromDesign
          ? { surface: lessDesign(measured, factor, design.data?.deviation_um) }
          : layered(measured, layer, fit.data?.result.residuals, earlier, correction.data)
        : undefined,
    [measured, layer, fit.data, earlier, correction.data, design.data, factor],
  );
  const waits = [
    nodes,
    ofFit && fit,
    layer === "difference" && before,
    ofCorrection && correction,
    fromDesign && design,
  ].filter((one) => one !== false);
  return {
    nodes,
    measured,
    surface: made?.surface,
    exact: made && "exact" in made ? made.exact : true,
    /** Residuals and fitted values of a curve have no surface. */
    residuals: fit.data?.result.residuals,
    answered: correction.data?.answer !== undefined && correction.data.answer !== null,
    correction: correction.data,
    errors: waits.flatMap(({ error, reload }) => (error === undefined ? [] : [{ error, reload }])),
    loading: waits.some(({ data, error }) => data === undefined && error === undefined),
  };
}

/** Returns measured heights minus the design, µm. @param {FlankSurface} measured @param {number | undefined} factor @param {readonly number[] | undefined} design */
function lessDesign(measured, factor, design) {
  if (factor === undefined || design === undefined) return undefined;
  return withHeights(
    measured,
    measured.z.map((z, k) => factor * z - (design[k] ?? Number.NaN)),
  );
}

/**
 * @param {FlankSurface} measured @param {LayerName} layer
 * @param {import("../api/client.js").Schema<"Residuals"> | undefined} residuals
 * @param {FlankSurface | undefined} earlier
 * @param {import("../api/client.js").Schema<"Correction"> | undefined} correction
 * @returns {{ surface: FlankSurface | undefined, exact?: boolean }}
 */
function layered(measured, layer, residuals, earlier, correction) {
  if (layer === "measured") return { surface: measured };
  if (layer === "teeth") return { surface: undefined };
  if (layer === "difference") return earlier ? difference(measured, earlier) : { surface: undefined };
  if (layer === "fitted" || layer === "residual") {
    const values = layer === "fitted" ? residuals?.fitted : residuals?.values;
    return { surface: values ? atNodes(measured, values, residuals?.node_indices) : undefined };
  }
  const list = layer === "predicted" ? correction?.result.predicted.deviation_um : correction?.answer?.measured_um;
  const surface = list ? atAllNodes(measured, list) : undefined;
  return { surface: surface && correction ? ofCorrection(surface, correction) : surface };
}
