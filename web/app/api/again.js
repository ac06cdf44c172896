// A request that stores and that a busy server has put off is sent again when the server says so, under the same
// Idempotency-Key, so that it is stored once; a few times at most, and not once somebody stops it.

import { signal } from "../../vendor/ui.js";

/** @typedef {{ seconds: number, stop: () => void }} PutOff */

/** What waits to be sent again. @type {import("../../vendor/ui.js").Signal<readonly PutOff[]>} */
export const putOff = signal(/** @type {readonly PutOff[]} */ ([]));

const MOST_TRIES = 5;
const LONGEST_S = 60;

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
  return seconds >= 0 && seconds <= LONGEST_S ? seconds : undefined;
}

/**
 * Whether the time has passed without being stopped.
 * @param {number} seconds @param {AbortSignal} ended
 * @returns {Promise<boolean>}
 */
function waited(seconds, ended) {
  return new Promise((resolve, reject) => {
    const settle = () => {
      clearTimeout(timer);
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
    const timer = setTimeout(() => end(true), 1000 * seconds);
    const entry = { seconds, stop: () => end(false) };
    putOff.value = [...putOff.value, entry];
    ended.addEventListener("abort", abort, { once: true });
    if (ended.aborted) abort();
  });
}
