// Whether the server answers. While it does not, it is asked again after 1 … 30 s; data that is
// shown stays.

import { signal } from "../../vendor/ui.js";
import { session } from "./key.js";

/** Since when the server has not answered. @type {import("../../vendor/ui.js").Signal<Date | null>} */
export const lostAt = signal(/** @type {Date | null} */ (null));

const LONGEST = 30_000;
let wait = 1000;
/** @type {ReturnType<typeof setTimeout> | undefined} */
let timer;

export function connected() {
  if (lostAt.peek() === null) return;
  lostAt.value = null;
  wait = 1000;
  clearTimeout(timer);
  // what could not be loaded is asked for again
  session.value += 1;
}

export function disconnected() {
  if (lostAt.peek() === null) {
    lostAt.value = new Date();
    schedule();
  }
}

/** Asks whether the server is there. */
export async function probe() {
  clearTimeout(timer);
  try {
    await fetch("/healthz", { cache: "no-store" });
    connected();
    return true;
  } catch {
    lostAt.value ??= new Date();
    wait = Math.min(2 * wait, LONGEST);
    schedule();
    return false;
  }
}

function schedule() {
  clearTimeout(timer);
  timer = setTimeout(probe, wait);
}

globalThis.addEventListener?.("online", () => {
  if (lostAt.peek() !== null) probe();
});

// A request that stores and that a busy server has put off is sent again when the server says so, under the same
// Idempotency-Key, so that it is stored once; a few times at most, and not once somebody stops it.

/** @typedef {{ seconds: number, stop: () => void }} PutOff */

/** What waits to be sent again. @type {import("../../vendor/ui.js").Signal<readonly PutOff[]>} */
export const putOff = signal(/** @type {readonly PutOff[]} */ ([]));

const MOST_TRIES = 5;
const LONGEST_PAUSE_S = 60;

/**
 * The answer to a request, after as many tries as it takes.
 * @param {Request} request @param {(request: Request) => Promise<Response>} send
 */
export async function sendAgain(request, send) {
  if (!request.headers.has("idempotency-key")) return send(request);
  for (let tries = 1; ; tries += 1) {
    // what is sent is read, and cannot be sent twice
    const copy = tries < MOST_TRIES ? request.clone() : request;
    const response = await send(copy);
    const seconds = secondsOf(response);
    if (tries === MOST_TRIES || seconds === undefined || !(await waited(seconds, request.signal))) return response;
  }
}

/** After how long a response asks to be asked again, where that is worth waiting for. @param {Response} response */
function secondsOf({ status, headers }) {
  const value = headers.get("retry-after");
  if (status !== 503 || value === null) return undefined;
  const seconds = Number(value);
  return seconds >= 0 && seconds <= LONGEST_PAUSE_S ? seconds : undefined;
}

/**
 * Whether the time has passed without being stopped.
 * @param {number} seconds @param {AbortSignal} ended
 * @returns {Promise<boolean>}
 */
function waited(seconds, ended) {
  return new Promise((resolve, reject) => {
    const settle = () => {
      clearTimeout(pause);
      ended.removeEventListener("abort", abort);
      putOff.value = putOff.value.filter((one) => one !== entry);
    };
    const end = (/** @type {boolean} */ passed) => {
      settle();
      resolve(passed);
    };
    const abort = () => {
      settle();
      reject(ended.reason);
    };
    const pause = setTimeout(() => end(true), 1000 * seconds);
    const entry = { seconds, stop: () => end(false) };
    putOff.value = [...putOff.value, entry];
    ended.addEventListener("abort", abort, { once: true });
    if (ended.aborted) abort();
  });
}
