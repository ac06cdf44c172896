// A long request: its progress, and a way to stop it.

import { useRef, useState } from "../../vendor/ui.js";
import { answer } from "./client.js";
import { withProgress } from "./progress.js";

/** A request that was stopped, although the data that had arrived may have been stored. */
export class CancelledError extends Error {}

/** @typedef {{ done: number, seconds: number | undefined } | undefined} Progress */
/** @typedef {{ signal: AbortSignal, fetch: ReturnType<typeof withProgress> }} How */
/**
 * @typedef {object} Watched
 * @property {boolean} running
 * @property {Progress} progress not known before the server has reported it
 * @property {() => void} stop
 * @property {<Data>(send: (how: How) => Parameters<typeof answer<Data>>[0], signal?: AbortSignal) => ReturnType<typeof answer<Data>>} run
 *   the answer; `signal` stops it too, as a page does that is left
 */

/** @returns {Watched} */
export function useWatched() {
  const [state, setState] = useState({ running: false, progress: /** @type {Progress} */ (undefined) });
  const abort = useRef(/** @type {AbortController | null} */ (null));
  return {
    ...state,
    stop: () => abort.current?.abort(),
    run: async (send, signal) => {
      const own = new AbortController();
      abort.current = own;
      const stop = () => own.abort();
      signal?.addEventListener("abort", stop, { once: true });
      // only the later of two overlapping requests is reported
      const update = (/** @type {typeof state} */ next) => {
        if (abort.current === own) setState(next);
      };
      update({ running: true, progress: undefined });
      try {
        const fetch = withProgress((progress) => update({ running: true, progress }));
        return await answer(send({ signal: own.signal, fetch }));
      } catch (error) {
        if (own.signal.aborted) throw new CancelledError("cancelled", { cause: error });
        throw error;
      } finally {
        signal?.removeEventListener("abort", stop);
        update({ running: false, progress: undefined });
      }
    },
  };
}
