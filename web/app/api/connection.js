// The state of the connection. While the server is not responding, it is polled after 1 … 30 s;
// data that is shown stays.

import { signal } from "../../vendor/ui.js";
import { currentKey, session } from "./key.js";
import { OfflineError } from "./problem.js";

/** The time since which the server has not responded. @type {import("../../vendor/ui.js").Signal<Date | null>} */
export const lostAt = signal(/** @type {Date | null} */ (null));

const LONGEST = 30_000;
let wait = 1000;
/** Set if a proxy reported the failure: it may still reach the server for other requests. */
let byProxy = false;
let foundAt = Number.NEGATIVE_INFINITY;
/** @type {ReturnType<typeof setTimeout> | undefined} */
let timer;

/** @param {boolean} [probed] the server was polled */
export function connected(probed = false) {
  // otherwise one failure behind a proxy would reload all data, again and again
  if (lostAt.peek() === null || (byProxy && !probed)) return;
  lostAt.value = null;
  foundAt = performance.now();
  clearTimeout(timer);
  // reload data that could not be loaded
  session.value += 1;
}

/** @param {boolean} [ofProxy] */
export function disconnected(ofProxy = false) {
  if (lostAt.peek() === null) {
    byProxy = ofProxy;
    // repeated failures lower the rate of requests
    wait = performance.now() - foundAt < 2 * LONGEST ? Math.min(2 * wait, LONGEST) : 1000;
    lostAt.value = new Date();
    schedule();
  }
}

/**
 * Returns true if a proxy has responded because its servers are away. A refusal of the server
 * itself is explained.
 * @param {Response} response
 */
export function isOfProxy({ status, headers }) {
  const explained = headers.get("content-type")?.startsWith("application/problem+json") ?? false;
  return status >= 502 && status <= 504 && !explained;
}

/** Checks that the server is responding. */
export async function probe() {
  clearTimeout(timer);
  try {
    if (isOfProxy(await fetch("/healthz", { cache: "no-store" }))) throw new Error("no server");
    connected(true);
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

// Resends a storing request that a busy server has deferred or that had no response: when the
// server says so, a few times at most, and until it is cancelled. The Idempotency-Key stays, so it
// is stored once.

/** @typedef {{ seconds: number, lost: boolean, stop: () => void }} PutOff `lost`: not busy, but away */

/** Requests that wait to be sent again. @type {import("../../vendor/ui.js").Signal<readonly PutOff[]>} */
export const putOff = signal(/** @type {readonly PutOff[]} */ ([]));

const MOST_TRIES = 5;
/** Limit since the first try, since a late request surprises. A refused connection uses up the tries in 15 s. */
const LONGEST_LOST_MS = 60_000;
const LONGEST_PAUSE_S = 60;

/**
 * Returns the response to a request, after as many tries as it takes.
 * @param {Request} request @param {(request: Request) => Promise<Response>} send
 */
export async function sendAgain(request, send) {
  if (!request.headers.has("idempotency-key")) return send(request);
  const key = currentKey();
  const begun = performance.now();
  for (let tries = 1; ; tries += 1) {
    // the body of a sent request is consumed, so it cannot be sent twice
    const copy = tries < MOST_TRIES ? request.clone() : request;
    const answered = await send(copy).catch(unanswered);
    const lost = answered instanceof OfflineError;
    const seconds = secondsBefore(tries, answered);
    const late = lost && performance.now() - begun > LONGEST_LOST_MS;
    const more = tries < MOST_TRIES && !late && seconds !== undefined;
    const goesOn = more && (await waited({ seconds, lost }, request.signal));
    // a request is not resent with another key
    if (goesOn && currentKey() === key) continue;
    if (lost) throw answered;
    return answered;
  }
}

/** @param {unknown} error */
function unanswered(error) {
  if (error instanceof OfflineError) return error;
  throw error;
}

/**
 * Returns the delay before another try, if one is worth it.
 * @param {number} tries so far @param {Response | OfflineError} outcome
 */
function secondsBefore(tries, outcome) {
  const pause = 2 ** (tries - 1);
  if (outcome instanceof OfflineError) return pause;
  const { status, headers } = outcome;
  const value = headers.get("retry-after");
  if ((status !== 503 && status !== 409) || value === null) return undefined;
  const seconds = Number(value);
  if (!(seconds >= 0 && seconds <= LONGEST_PAUSE_S)) return undefined;
  // the server is still processing the first request, which may take longer than it says each time
  return status === 409 ? Math.max(seconds, pause) : seconds;
}

/**
 * Waits, and returns false if it was stopped.
 * @param {Omit<PutOff, "stop">} why @param {AbortSignal} ended
 * @returns {Promise<boolean>}
 */
function waited(why, ended) {
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
    const pause = setTimeout(() => end(true), 1000 * why.seconds);
    const entry = { ...why, stop: () => end(false) };
    putOff.value = [...putOff.value, entry];
    ended.addEventListener("abort", abort, { once: true });
    if (ended.aborted) abort();
  });
}
