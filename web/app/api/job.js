// A job and its trace, as several pages need them.

import { answer, api } from "./client.js";
import { useResource } from "./resource.js";

/** @typedef {import("./client.js").Schema<"Job">} Job */
/** @typedef {import("./client.js").Schema<"TracedIteration">} TracedIteration */
/** @typedef {{ job: Job, iterations: TracedIteration[] }} WholeTrace */

/** @param {string} jobId */
export function useJob(jobId) {
  const params = { path: { job_id: jobId } };
  return useResource(`job ${jobId}`, (signal) => answer(api.GET("/v1/jobs/{job_id}", { signal, params })));
}

/** All iterations of a job, page by page. @param {string} jobId */
export function useTrace(jobId) {
  return useResource(`trace ${jobId}`, (signal) => wholeTrace(jobId, signal));
}

/** @param {string} jobId @param {AbortSignal} signal @returns {Promise<{ data: WholeTrace }>} */
async function wholeTrace(jobId, signal) {
  /** @type {TracedIteration[]} */
  const iterations = [];
  /** @type {string | null | undefined} */
  let cursor;
  for (;;) {
    const query = { limit: 100, ...(cursor ? { cursor } : {}) };
    const pending = api.GET("/v1/jobs/{job_id}/trace", { signal, params: { path: { job_id: jobId }, query } });
    const { data } = await answer(pending);
    iterations.push(...data.iterations);
    cursor = data.next_cursor;
    if (!cursor) return { data: { job: data.job, iterations } };
  }
}

/** Returns the chosen fit. @param {TracedIteration} iteration */
export function chosenFit({ fits }) {
  return fits.find(({ chosen }) => chosen) ?? fits.at(-1);
}
