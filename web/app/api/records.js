// Records of an iteration: evaluations, corrections and the like.

import { answer, api } from "./client.js";
import { useResource } from "./resource.js";

/** @typedef {import("./client.js").Schema<"RecordSummary">} RecordSummary */
/** @typedef {import("./client.js").Schema<"JobRecord">} JobRecord */

/** Returns all records of an iteration, oldest first, without their contents. @param {string} jobId @param {number} number */
export function useRecords(jobId, number) {
  return useResource(`records ${jobId} ${number}`, (signal) => allRecords(jobId, number, signal));
}

/** @param {string} jobId @param {number} number @param {AbortSignal} signal */
async function allRecords(jobId, number, signal) {
  /** @type {RecordSummary[]} */
  const records = [];
  /** @type {string | null | undefined} */
  let cursor;
  for (;;) {
    const query = { limit: 200, ...(cursor ? { cursor } : {}) };
    const params = { path: { job_id: jobId, number }, query };
    const { data } = await answer(api.GET("/v1/jobs/{job_id}/iterations/{number}/records", { signal, params }));
    records.push(...data.items);
    cursor = data.next_cursor;
    if (!cursor) return { data: records };
  }
}

/** Returns a record in full, if there is an ID. @param {string} jobId @param {number} number @param {string | undefined} id */
export function useRecord(jobId, number, id) {
  return useResource(id === undefined ? null : `record ${jobId} ${number} ${id}`, (signal) => {
    const params = { path: { job_id: jobId, number, record_id: id ?? "" } };
    return answer(api.GET("/v1/jobs/{job_id}/iterations/{number}/records/{record_id}", { signal, params }));
  });
}
