// A stream of nodes that is being measured, and its estimates since it has been looked at: the
// server answers the last one only.

import { useEffect, useRef } from "../../vendor/ui.js";
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

/** Does at once what has rested for long enough, and else as soon as it has. @param {number} wait @param {() => void} act */
function useAtMostEvery(wait, act) {
  const last = useRef(Number.NEGATIVE_INFINITY);
  const timer = useRef(/** @type {ReturnType<typeof setTimeout> | undefined} */ (undefined));
  useEffect(() => () => clearTimeout(timer.current), []);
  return () => {
    clearTimeout(timer.current);
    const now = () => {
      last.current = performance.now();
      act();
    };
    const rest = wait - (performance.now() - last.current);
    if (rest <= 0) now();
    else timer.current = setTimeout(now, rest);
  };
}
