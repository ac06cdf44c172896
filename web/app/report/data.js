// All data of a report: each iteration with its chosen fit, nodes, evaluation and correction.

import { answer, api } from "../api/client.js";
import { may } from "../api/key.js";
import { useResource } from "../api/resource.js";
import { surfaceOf } from "../flank/layers.js";

/** @typedef {import("../api/client.js").Schema<"Iteration">} Iteration */
/** @typedef {import("../api/client.js").Schema<"IterationFit">} IterationFit */
/** @typedef {import("../api/client.js").Schema<"Nodes">} Nodes */
/** @typedef {import("../api/client.js").Schema<"JobRecord">} JobRecord */
/** @typedef {import("../api/client.js").Schema<"Correction">} Correction */
/** @typedef {import("../api/client.js").Schema<"GearEvaluation">} GearEvaluation */
/** @typedef {import("../api/client.js").Schema<"GearTolerances">} GearTolerances */
/** @typedef {import("../api/client.js").Schema<"PitchEvaluation">} PitchEvaluation */
/** @typedef {import("../api/client.js").Schema<"EvaluateGear">} EvaluateGear */
/** @typedef {import("../api/client.js").Schema<"Gear">} Gear */
/** @typedef {import("../api/job.js").Job} Job */
/** @typedef {import("../api/job.js").TracedIteration} TracedIteration */
/**
 * @typedef {object} ReportData
 * @property {Iteration} iteration
 * @property {TracedIteration} traced
 * @property {IterationFit | undefined} fit the chosen one
 * @property {Nodes} nodes
 * @property {import("../flank/surface.js").FlankSurface | undefined} surface none of a curve or a matrix
 * @property {Evaluated | undefined} evaluated the latest evaluation of traces
 * @property {Pitched | undefined} pitched the latest evaluation of pitches
 * @property {Correction | undefined} correction made from it
 * @property {Correction | undefined} measuredCorrection the previous correction, whose response it measured
 */
/** @typedef {{ record: JobRecord, result: GearEvaluation, request: Partial<EvaluateGear>, gear: Gear | undefined, tolerances: GearTolerances | undefined }} Evaluated */
/** @typedef {{ record: JobRecord, result: PitchEvaluation }} Pitched */

/** @param {Job} job @param {readonly TracedIteration[]} traced @param {readonly number[]} numbers none: nothing is requested */
export function useReport(job, traced, numbers) {
  // another chosen fit or another record makes another report
  const state = traced.map(({ choices, records }) => [choices.at(-1)?.created_at, records?.at(-1)?.id]);
  const key = `report ${job.id} ${numbers.join(",")} ${JSON.stringify(state)}`;
  return useResource(numbers.length > 0 ? key : null, async (signal) => {
    /** @type {ReportData[]} */
    const data = [];
    // one after the other: a report of many iterations leaves capacity for others
    for (const number of numbers) {
      const own = traced.find((one) => one.number === number);
      if (own) data.push(await reportDataOf(job, traced, own, signal));
    }
    return { data };
  });
}

/** @param {Job} job @param {readonly TracedIteration[]} traced @param {TracedIteration} own @param {AbortSignal} signal @returns {Promise<ReportData>} */
async function reportDataOf(job, traced, own, signal) {
  const path = { job_id: job.id, number: own.number };
  const before = traced.findLast(
    ({ number, flank, tooth }) => number < own.number && flank === own.flank && tooth === own.tooth,
  );
  const latest = (/** @type {"evaluation" | "pitch"} */ wanted) =>
    own.records?.findLast(({ kind }) => kind === wanted)?.id;
  const [evaluation, pitch] = [latest("evaluation"), latest("pitch")];
  const [whole, nodes, evaluated, pitched, correction, earlier] = await Promise.all([
    answer(api.GET("/v1/jobs/{job_id}/iterations/{number}", { signal, params: { path } })),
    answer(
      api.GET("/v1/jobs/{job_id}/iterations/{number}/nodes", {
        signal,
        params: { path },
        headers: { accept: "application/json" },
      }),
    ),
    evaluation ? evaluatedOf(job, own.number, evaluation, signal) : undefined,
    pitch ? pitchedOf(job.id, own.number, pitch, signal) : undefined,
    correctionOf(job.id, own, signal),
    before ? correctionOf(job.id, before, signal) : undefined,
  ]);
  const fit_id = whole.data.fits.find(({ chosen }) => chosen)?.id;
  const fit = fit_id
    ? await answer(
        api.GET("/v1/jobs/{job_id}/iterations/{number}/fits/{fit_id}", {
          signal,
          params: { path: { ...path, fit_id }, query: { include: ["residuals", "lambda_curve"] } },
        }),
      )
    : undefined;
  const heights = /** @type {Nodes} */ (nodes.data);
  return {
    iteration: whole.data,
    traced: own,
    fit: fit?.data,
    nodes: heights,
    surface: surfaceOf(heights),
    evaluated,
    pitched,
    correction,
    measuredCorrection: earlier?.answer?.iteration === own.number ? earlier : undefined,
  };
}

/** @param {string} job_id @param {number} number @param {string} record_id @param {AbortSignal} signal */
async function recordOf(job_id, number, record_id, signal) {
  const { data } = await answer(
    api.GET("/v1/jobs/{job_id}/iterations/{number}/records/{record_id}", {
      signal,
      params: { path: { job_id, number, record_id } },
    }),
  );
  return /** @type {JobRecord} */ (data);
}

/** @param {string} jobId @param {number} number @param {string} id @param {AbortSignal} signal @returns {Promise<Pitched>} */
async function pitchedOf(jobId, number, id, signal) {
  const record = await recordOf(jobId, number, id, signal);
  return { record, result: /** @type {PitchEvaluation} */ (/** @type {unknown} */ (record.result)) };
}

/** @param {Job} job @param {number} number @param {string} id @param {AbortSignal} signal @returns {Promise<Evaluated>} */
async function evaluatedOf(job, number, id, signal) {
  const record = await recordOf(job.id, number, id, signal);
  const result = /** @type {GearEvaluation} */ (/** @type {unknown} */ (record.result));
  const request = /** @type {Partial<EvaluateGear>} */ (record.request);
  const gear = request.gear ?? record.gear ?? job.gear ?? undefined;
  const of = result.evaluation.tolerance_limits?.class;
  const tolerances =
    gear && typeof of === "number" && may("compute")
      ? (await answer(api.POST("/v1/gears/tolerances", { signal, body: { gear, class: of } }))).data
      : undefined;
  return { record, result, request, gear, tolerances };
}

/** @param {string} jobId @param {TracedIteration} own @param {AbortSignal} signal */
async function correctionOf(jobId, own, signal) {
  if (!own.records?.some(({ kind }) => kind === "correction")) return undefined;
  const params = {
    path: { job_id: jobId, number: own.number },
    query: { include: /** @type {["nodes"]} */ (["nodes"]) },
  };
  const headers = { accept: "application/json" };
  const pending = api.GET("/v1/jobs/{job_id}/iterations/{number}/correction", { signal, params, headers });
  return /** @type {Correction} */ ((await answer(pending)).data);
}
