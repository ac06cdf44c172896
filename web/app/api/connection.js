// Whether the server answers. While it does not, it is asked again after 1 … 30 s; data that is
// shown stays.

import { signal } from "../../vendor/ui.js";
import { currentKey, session } from "./key.js";
import { OfflineError } from "./problem.js";

/** Since when the server has not answered. @type {import("../../vendor/ui.js").Signal<Date | null>} */
export const lostAt = signal(/** @type {Date | null} */ (null));

const LONGEST = 30_000;
let wait = 1000;
/** Whether it was a proxy that has said so: it may answer others meanwhile. */
let byProxy = false;
let foundAt = Number.NEGATIVE_INFINITY;
/** @type {ReturnType<typeof setTimeout> | undefined} */
let timer;

/** @param {boolean} [probed] the server was asked whether it is there */
export function connected(probed = false) {
  // else one answer that a proxy has not would have all others asked for anew, again and again
  if (lostAt.peek() === null || (byProxy && !probed)) return;
  lostAt.value = null;
  foundAt = performance.now();
  clearTimeout(timer);
  // what could not be loaded is asked for again
  session.value += 1;
}

/** @param {boolean} [ofProxy] */
export function disconnected(ofProxy = false) {
  if (lostAt.peek() === null) {
    byProxy = ofProxy;
    // what is lost again at once is asked less and less often
    wait = performance.now() - foundAt < 2 * LONGEST ? Math.min(2 * wait, LONGEST) : 1000;
    lostAt.value = new Date();
    schedule();
  }
}

/**
 * Whether a proxy has answered, since the servers behind it are away or the one that it asked was lost: what a server
 * refuses it explains.
 * @param {Response} response
 */
export function isOfProxy({ status, headers }) {
  const explained = headers.get("content-type")?.startsWith("application/problem+json") ?? false;
  return status >= 502 && status <= 504 && !explained;
}

/** Asks whether the server is there. */
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

// A request that stores and that a busy server has put off is sent again when the server says so, under the same
// Idempotency-Key, so that it is stored once; a few times at most, and not once somebody stops it. So is one that nobody
// has answered: the server may have been lost with it, and another or the same may be there again.

/** @typedef {{ seconds: number, lost: boolean, stop: () => void }} PutOff `lost`: not busy, but away */

/** What waits to be sent again. @type {import("../../vendor/ui.js").Signal<readonly PutOff[]>} */
export const putOff = signal(/** @type {readonly PutOff[]} */ ([]));

const MOST_TRIES = 5;
/** Since the first try; what is sent long after it was meant surprises. A refused connection takes the tries in 15 s. */
const LONGEST_LOST_MS = 60_000;
const LONGEST_PAUSE_S = 60;

/**
 * The answer to a request, after as many tries as it takes.
 * @param {Request} request @param {(request: Request) => Promise<Response>} send
 */
export async function sendAgain(request, send) {
  if (!request.headers.has("idempotency-key")) return send(request);
  const key = currentKey();
  const begun = performance.now();
  for (let tries = 1; ; tries += 1) {
    // what is sent is read, and cannot be sent twice
    const copy = tries < MOST_TRIES ? request.clone() : request;
    const answered = await send(copy).catch(unanswered);
    const lost = answered instanceof OfflineError;
    const seconds = secondsBefore(tries, answered);
    const late = lost && performance.now() - begun > LONGEST_LOST_MS;
    const more = tries < MOST_TRIES && !late && seconds !== undefined;
    const goesOn = more && (await waited({ seconds, lost }, request.signal));
    // what somebody has sent is not sent by another
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
 * How long to wait before another try, where that is worth it.
 * @param {number} tries so far @param {Response | OfflineError} answered
 */
function secondsBefore(tries, answered) {
  const pause = 2 ** (tries - 1);
  if (answered instanceof OfflineError) return pause;
  const { status, headers } = answered;
  const value = headers.get("retry-after");
  if ((status !== 503 && status !== 409) || value === null) return undefined;
  const seconds = Number(value);
  if (!(seconds >= 0 && seconds <= LONGEST_PAUSE_S)) return undefined;
  // the server still does what was sent first, which may take longer than it says each time
  return status === 409 ? Math.max(seconds, pause) : seconds;
}

/**
 * Whether the time has passed without being stopped.
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
