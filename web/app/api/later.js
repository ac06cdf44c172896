// What may take long is asked for so that it can be answered later (`Prefer: respond-async`): how far it is can be
// shown, and it can be stopped without anything being stored.

import { answer, api } from "./client.js";
import { ApiError, OfflineError } from "./problem.js";

/** @typedef {import("./client.js").Schema<"Operation">} Operation */
/** @typedef {(progress: { done: number, seconds: number | undefined } | undefined) => void} Tell `done` from 0 to 1; `seconds` that remain */
/** @template Data @typedef {{ data?: Data, error?: unknown, response: Response }} Pending */

/** An answer that comes within a second is none that anybody waits for. */
const PREFER = { Prefer: "respond-async, wait=1" };
/** How long a request that is stopped may take to say under which id it goes on. */
const GRACE_MS = 1500;
/** How often at most an operation is asked about before somebody answers: a restart does not end it. */
const MOST_TRIES = 5;

/** It was stopped, and the server has said that nothing is stored. */
export class StoppedError extends Error {}

/**
 * The answer, once it is there.
 * @template Data
 * @param {(more: { header: typeof PREFER, signal: AbortSignal }) => Promise<Pending<Data>>} send
 * @param {{ signal: AbortSignal, tell?: Tell }} watch `signal` stops it
 * @returns {ReturnType<typeof answer<Data>>}
 */
export async function answerLater(send, { signal, tell }) {
  const sending = new AbortController();
  const stop = () => setTimeout(() => sending.abort(), GRACE_MS);
  signal.addEventListener("abort", stop, { once: true });
  if (signal.aborted) stop();
  const first = await send({ header: PREFER, signal: sending.signal });
  signal.removeEventListener("abort", stop);
  if (first.response.status !== 202) return answer(Promise.resolve(first));
  const { id } = /** @type {Operation} */ (/** @type {unknown} */ (first.data));
  const params = { path: { operation_id: id } };
  try {
    await ended(id, signal, tell);
    return await patiently(signal, () => {
      const result = api.GET("/v1/operations/{operation_id}/result", { signal, params });
      return answer(/** @type {Promise<Pending<Data>>} */ (/** @type {unknown} */ (result)));
    });
  } catch (error) {
    if (signal.aborted && (await isCancelled(id))) throw new StoppedError("cancelled", { cause: error });
    throw error;
  }
}

/** Waits for the end. @param {string} id @param {AbortSignal} signal @param {Tell} [tell] */
async function ended(id, signal, tell) {
  // the server holds each answer back for a second, unless the operation ends before
  const params = { path: { operation_id: id }, header: { Prefer: "wait=1" } };
  for (;;) {
    signal.throwIfAborted();
    const look = () => answer(api.GET("/v1/operations/{operation_id}", { signal, params }));
    const { data } = await patiently(signal, look);
    const { state, progress, remaining_seconds: seconds } = /** @type {Operation} */ (data);
    if (state !== "queued" && state !== "running") return;
    tell?.({ done: progress, seconds });
  }
}

/**
 * What is answered once somebody answers, after 1, 2, 4 … s without, or once a server says that it can again.
 * @template Answer
 * @param {AbortSignal} signal @param {() => Promise<Answer>} ask
 */
async function patiently(signal, ask) {
  for (let tries = 1; ; tries += 1) {
    try {
      return await ask();
    } catch (error) {
      const put = error instanceof ApiError && error.status === 503 ? error.retryAfter : undefined;
      const seconds = error instanceof OfflineError ? 2 ** (tries - 1) : put;
      if (seconds === undefined || tries === MOST_TRIES) throw error;
      await passed(1000 * seconds, signal);
    }
  }
}

/** @param {number} time in ms @param {AbortSignal} signal ends it at once */
function passed(time, signal) {
  return new Promise((resolve) => {
    const timer = setTimeout(resolve, time);
    signal.addEventListener("abort", () => resolve(clearTimeout(timer)), { once: true });
    if (signal.aborted) resolve(clearTimeout(timer));
  });
}

/** Cancels, and asks whether that was in time. @param {string} id */
async function isCancelled(id) {
  const params = { path: { operation_id: id } };
  await answer(api.DELETE("/v1/operations/{operation_id}", { params }));
  const { data } = await answer(api.GET("/v1/operations/{operation_id}", { params }));
  return /** @type {Operation} */ (data).state === "cancelled";
}
