// At most one request under way; of the requests wanted meanwhile only the last is sent.

import { useLayoutEffect, useRef, useState } from "../../vendor/ui.js";
import { underway } from "./resource.js";

/**
 * @template Content, Data
 * @param {Content | undefined} content undefined requests nothing; compared as JSON
 * @param {(content: Content, signal: AbortSignal) => Promise<Data>} send
 * @returns {{ data: Data | undefined, of: Content | undefined, error: unknown, current: boolean }}
 *   `data` is the answer to `of`; `current`: that is what is wanted now
 */
export function useLatest(content, send) {
  const [state, setState] = useState(
    /** @type {{ data?: Data, of?: Content, key?: string, error?: unknown }} */ ({ error: undefined }),
  );
  const wanted = useRef(/** @type {{ key: string, content: Content } | undefined} */ (undefined));
  const running = useRef(false);
  const abort = useRef(new AbortController());
  const key = content === undefined ? undefined : JSON.stringify(content);

  const run = async () => {
    if (running.current) return;
    running.current = true;
    underway.value += 1;
    const { signal } = abort.current;
    try {
      for (let done = ""; wanted.current && wanted.current.key !== done && !signal.aborted; ) {
        const now = wanted.current;
        done = now.key;
        try {
          const data = await send(now.content, signal);
          if (!signal.aborted) setState({ data, of: now.content, key: now.key, error: undefined });
        } catch (error) {
          if (!signal.aborted) setState((last) => ({ ...last, key: now.key, error }));
        }
      }
    } finally {
      running.current = false;
      underway.value -= 1;
    }
  };

  useLayoutEffect(() => {
    abort.current = new AbortController();
    return () => abort.current.abort();
  }, []);
  // before the browser paints: see `useResource`
  useLayoutEffect(() => {
    wanted.current = key === undefined ? undefined : { key, content: /** @type {Content} */ (content) };
    if (key !== undefined && key !== state.key) void run();
  }, [key]);
  return { data: state.data, of: state.of, error: state.error, current: state.key === key };
}
