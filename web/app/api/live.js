// Changes by others to the job that is shown, or to any job: one event stream per visible tab. It
// resumes after the last event, reconnects after 1 … 30 s, and is closed in tabs that have been
// hidden for 30 s, since a browser has six connections per server. While somebody types, events are
// held back, so that nothing jumps.

import { useEffect, useRef } from "../../vendor/ui.js";
import { eventsOf } from "../lib/event_stream.js";
import { transport } from "./client.js";
import { keyWanted, session } from "./key.js";

/** @typedef {import("./client.js").Schema<"JobEvent">} JobEvent */
/** @typedef {(events: JobEvent[]) => void} Listener is called without events when the stream has begun: something may have been missed */

const LONGEST = 30_000;
const HIDDEN = 30_000;

/**
 * Follows a job as long as its page is shown.
 * @param {string | null} jobId null follows nothing
 * @param {Listener} listener
 */
export function useJobEvents(jobId, listener) {
  useEvents(jobId === null ? null : `/v1/jobs/${encodeURIComponent(jobId)}/events`, listener);
}

/** Follows all jobs as long as the page is shown. @param {Listener} listener */
export function useEventsOfAllJobs(listener) {
  useEvents("/v1/events", listener);
}

/** @param {string | null} path @param {Listener} listener */
function useEvents(path, listener) {
  const latest = useRef(listener);
  latest.current = listener;
  useEffect(() => {
    if (path === null) return undefined;
    return follow(path, (events) => latest.current(events));
  }, [path, session.value]);
}

/** @param {string} path @param {Listener} notify @returns {() => void} ends it */
function follow(path, notify) {
  const place = new URL(path, location.origin);
  let last = "latest";
  let wait = 1000;
  let begun = false;
  let ended = false;
  /** @type {AbortController | undefined} */
  let open;
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  let timer;
  const { notify: notifyQuietly, stop } = whenNobodyTypes(notify);

  const connect = async () => {
    open = new AbortController();
    const { signal } = open;
    try {
      const headers = { accept: "text/event-stream", "last-event-id": last };
      const response = await transport(new Request(place, { headers, signal, cache: "no-store" }));
      if (!response.ok || !response.body) {
        // the key was valid when the page was opened
        if (begun && response.status === 401) keyWanted.value = "unauthorized";
        // stop if the caller lacks permission or the resource is gone
        if (response.status < 500 && response.status !== 429) return;
        throw new Error(`events: ${response.status}`);
      }
      wait = 1000;
      begun = true;
      notifyQuietly([]);
      await read(response.body);
    } catch {
      // the transport has reported the lost connection
    }
    open = undefined;
    if (ended || signal.aborted) return;
    timer = setTimeout(connect, wait);
    wait = Math.min(2 * wait, LONGEST);
  };

  /** @param {ReadableStream<Uint8Array>} body */
  const read = async (body) => {
    for await (const found of eventsOf(body)) {
      if (found.length === 0) continue;
      last = found.at(-1)?.id || last;
      notifyQuietly(found.map(({ data }) => JSON.parse(data)));
    }
  };

  const close = () => {
    clearTimeout(timer);
    open?.abort();
    open = undefined;
  };
  const turn = () => {
    clearTimeout(timer);
    if (document.visibilityState === "hidden") timer = setTimeout(close, HIDDEN);
    else if (!open) connect();
  };
  document.addEventListener("visibilitychange", turn);
  turn();
  return () => {
    ended = true;
    document.removeEventListener("visibilitychange", turn);
    close();
    stop();
  };
}

/** Holds back events while a dialog is open or a field has the focus. @param {Listener} notify */
function whenNobodyTypes(notify) {
  /** @type {JobEvent[] | undefined} */
  let waiting;
  const flush = () => {
    if (waiting === undefined || isTyping()) return;
    const events = waiting;
    waiting = undefined;
    notify(events);
  };
  // the focus has moved on once the event is over
  const later = () => setTimeout(flush);
  document.addEventListener("focusout", later);
  document.addEventListener("close", later, true);
  return {
    /** @param {JobEvent[]} events */
    notify: (events) => {
      waiting = [...(waiting ?? []), ...events];
      flush();
    },
    stop: () => {
      document.removeEventListener("focusout", later);
      document.removeEventListener("close", later, true);
    },
  };
}

function isTyping() {
  const field = document.activeElement?.matches("input:not([type=checkbox]), textarea, select") ?? false;
  return field || document.querySelector("dialog[open]") !== null;
}

/**
 * Calls `act` at once if the last call was long enough ago, else as soon as that is so. A new page
 * counts as a call.
 * @param {number} wait in ms @param {() => void} act
 */
export function useAtMostEvery(wait, act) {
  const last = useRef(performance.now());
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
