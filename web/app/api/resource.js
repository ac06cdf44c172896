// Data of a page: loaded, kept while it is reloaded, with its error.
//
//     const job = useResource(`job ${id}`, (signal) => answer(api.GET(…, { signal })));
//     html`${loaded({ resource: job, children: (data) => … })}`

import { signal, useCallback, useLayoutEffect, useState } from "../../vendor/ui.js";
import { session } from "./key.js";
import { ApiError } from "./problem.js";

/**
 * @template Data
 * @typedef {object} Resource
 * @property {Data | undefined} data what was loaded last
 * @property {string | undefined} etag its version
 * @property {unknown} error why the last attempt failed
 * @property {boolean} loading
 * @property {() => void} reload
 * @property {(data: Data, etag: string | undefined) => void} put takes the result of a change
 */

/** The number of resources being loaded; `main` is busy until it is 0. */
export const underway = signal(0);

/** The data loaded last, so that a page appears at once when somebody returns to it. @type {Map<string, { data: unknown, etag: string | undefined }>} */
const kept = new Map();
const MOST_KEPT = 60;

/** @param {string} key @param {{ data: unknown, etag: string | undefined }} value */
function keep(key, value) {
  kept.delete(key);
  kept.set(key, value);
  const oldest = kept.keys().next().value;
  if (kept.size > MOST_KEPT && oldest !== undefined) kept.delete(oldest);
}

/** Discards all loaded data: another key may see other things. */
export function forgetResources() {
  kept.clear();
}

/**
 * @template Data
 * @param {string | null} key names what is loaded; another key is another thing; null loads nothing
 * @param {(signal: AbortSignal) => Promise<{ data: Data, etag?: string | undefined }>} load
 * @returns {Resource<Data>}
 */
export function useResource(key, load) {
  const [turn, setTurn] = useState(0);
  const [state, setState] = useState(() => begin(key));
  const current = state.key === key ? state : begin(key);

  // the same key is the same resource, so `load` is no dependency; before the browser paints, so
  // that no page appears between a resource and the next one it requests
  useLayoutEffect(() => {
    if (key === null) return undefined;
    const abort = new AbortController();
    /** @type {ReturnType<typeof setTimeout> | undefined} */
    let again;
    let counted = true;
    underway.value += 1;
    const settled = () => {
      if (counted) underway.value -= 1;
      counted = false;
    };
    setState((last) => ({ ...(last.key === key ? last : begin(key)), loading: true }));
    load(abort.signal).then(
      ({ data, etag }) => {
        if (abort.signal.aborted) return;
        keep(key, { data, etag });
        setState({ key, data, etag, error: undefined, loading: false });
        settled();
      },
      (/** @type {unknown} */ error) => {
        if (abort.signal.aborted) return;
        setState((last) => ({ ...(last.key === key ? last : begin(key)), error, loading: false }));
        settled();
        if (error instanceof ApiError && error.status === 503 && error.retryAfter !== undefined) {
          again = setTimeout(() => setTurn((last) => last + 1), 1000 * error.retryAfter);
        }
      },
    );
    return () => {
      abort.abort();
      clearTimeout(again);
      settled();
    };
  }, [key, turn, session.value]);

  const reload = useCallback(() => setTurn((last) => last + 1), []);
  const put = useCallback(
    (/** @type {Data} */ data, /** @type {string | undefined} */ etag) => {
      if (key === null) return;
      keep(key, { data, etag });
      setState({ key, data, etag, error: undefined, loading: false });
    },
    [key],
  );
  const { data, etag, error, loading } = current;
  return { data: /** @type {Data | undefined} */ (data), etag, error, loading, reload, put };
}

/** @param {string | null} key @returns {{ key: string | null, data: unknown, etag: string | undefined, error: unknown, loading: boolean }} */
function begin(key) {
  const known = key === null ? undefined : kept.get(key);
  return { key, data: known?.data, etag: known?.etag, error: undefined, loading: key !== null };
}
