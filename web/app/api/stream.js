// A stream of nodes being measured, and its estimates since the page was opened: the server returns
// the last one only.

import { useRef } from "../../vendor/ui.js";
import { answer, api } from "./client.js";
import { useAtMostEvery } from "./live.js";
import { useResource } from "./resource.js";

/** @typedef {import("./client.js").Schema<"Stream">} Stream */
/** @typedef {import("./client.js").Schema<"FitResult">} FitResult */
/** @typedef {{ nodes: number, result: FitResult }} Estimate */

/** Delay for at most two requests a second. */
const LEAST_WAIT = 500;
const MOST_KEPT = 2000;

/** @type {Map<string, Estimate[]>} */
const histories = new Map();

/** @typedef {{ after: number, u: number[], v: number[], z: number[] }} Gathered */
/** The nodes of streams as far as they have been loaded. @type {Map<string, Gathered>} */
const gathered = new Map();

/** @param {string} streamId */
export function useStream(streamId) {
  const resource = useResource(`stream ${streamId}`, async (signal) => {
    const got = await answer(api.GET("/v1/streams/{stream_id}", { signal, params: { path: { stream_id: streamId } } }));
    remember(got.data);
    return got;
  });
  const wake = useAtMostEvery(LEAST_WAIT, resource.reload);
  return { resource, history: histories.get(streamId) ?? [], wake };
}

/**
 * Returns the streams of a job that are being measured, among its first 200: the server lists the
 * oldest first and cannot filter by state.
 * @param {string} jobId
 */
export function useOpenStreams(jobId) {
  return useResource(`open streams ${jobId}`, async (signal) => {
    const params = { path: { job_id: jobId }, query: { limit: 200 } };
    const { data } = await answer(api.GET("/v1/jobs/{job_id}/streams", { signal, params }));
    return { data: data.items.filter(({ state }) => state === "open") };
  });
}

/** @param {Stream} stream */
function remember({ id, node_count: nodes, result }) {
  const history = histories.get(id) ?? [];
  if (!result || (history.at(-1)?.nodes ?? -1) >= nodes) return;
  histories.set(id, [...history.slice(1 - MOST_KEPT), { nodes, result }]);
}

/**
 * Returns the nodes so far; only new blocks are requested, and none of curves.
 * @param {Stream} stream
 */
export function useStreamNodes({ id, sequence, state }) {
  const open = state === "open" && sequence > 0;
  const resource = useResource(open ? `nodes of stream ${id} up to ${sequence}` : null, async (signal) => {
    for (;;) {
      const { after } = gathered.get(id) ?? { after: 0 };
      const params = { path: { stream_id: id }, query: { after } };
      const { data } = await answer(api.GET("/v1/streams/{stream_id}/nodes", { signal, params }));
      const { items, sequence: there } = data;
      gather(id, items);
      const last = items.at(-1);
      if (!last || last.sequence >= there) break;
    }
    const { u, v, z } = gathered.get(id) ?? { u: [], v: [], z: [] };
    return { data: { u: [...u], v: [...v], z: [...z] } };
  });
  // the previous data stays until the next is there
  const last = useRef(resource.data);
  if (resource.data) last.current = resource.data;
  return { ...resource, data: resource.data ?? last.current };
}

/** Adds each block once, whichever of two responses brings it. @param {string} id @param {readonly import("./client.js").Schema<"PostedStreamBlock">[]} blocks */
function gather(id, blocks) {
  const all = gathered.get(id) ?? { after: 0, u: [], v: [], z: [] };
  for (const { sequence, nodes } of blocks) {
    if (sequence <= all.after) continue;
    all.after = sequence;
    if (nodes.type === "scattered") for (const [i, u] of nodes.u.entries()) add(all, u, nodes.v[i] ?? 0, nodes.z[i]);
    if (nodes.type === "grid")
      for (const [i, u] of nodes.u.entries())
        for (const [j, v] of nodes.v.entries())
          add(all, u, v, nodes.valid?.[i]?.[j] === false ? null : nodes.z[i]?.[j]);
  }
  gathered.set(id, all);
}

/** @param {Gathered} all @param {number} u @param {number} v @param {number | null | undefined} z */
function add(all, u, v, z) {
  if (z === null || z === undefined) return;
  all.u.push(u);
  all.v.push(v);
  all.z.push(z);
}
