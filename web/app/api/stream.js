// A stream of nodes that is being measured, and its estimates since it has been looked at: the
// server answers the last one only.

import { useAtMostEvery } from "../lib/at_most.js";
import { answer, api } from "./client.js";
import { useResource } from "./resource.js";

/** @typedef {import("./client.js").Schema<"Stream">} Stream */
/** @typedef {import("./client.js").Schema<"FitResult">} FitResult */
/** @typedef {{ nodes: number, result: FitResult }} Estimate */

/** At most two requests a second. */
const LEAST_WAIT = 500;
const MOST_KEPT = 2000;

/** @type {Map<string, Estimate[]>} */
const histories = new Map();

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

/** @param {Stream} stream */
function remember({ id, node_count: nodes, result }) {
  const history = histories.get(id) ?? [];
  if (!result || (history.at(-1)?.nodes ?? -1) >= nodes) return;
  histories.set(id, [...history.slice(1 - MOST_KEPT), { nodes, result }]);
}
