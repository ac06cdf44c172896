// Requests with progress (`Accept: text/event-stream`): the last event is the result. Aborting
// closes the connection, which cancels the work.

import { eventsOf } from "../lib/event_stream.js";
import { transport } from "./client.js";
import { sendAgain } from "./connection.js";
import { OfflineError } from "./problem.js";

/** @typedef {(progress: { done: number, seconds: number | undefined }) => void} OnProgress `done` from 0 to 1; `seconds` that remain */

/**
 * Returns a `fetch` for such requests: its response is that of the plain request.
 * @param {OnProgress} onProgress
 * @returns {(request: Request) => Promise<Response>}
 */
export const withProgress = (onProgress) => (request) => sendAgain(request, (one) => followed(one, onProgress));

/** @param {Request} request @param {OnProgress} onProgress */
async function followed(request, onProgress) {
  request.headers.set("accept", "text/event-stream");
  const response = await transport(request);
  // an immediate refusal has no events
  if (!response.ok || !response.body) return response;
  try {
    for await (const events of eventsOf(response.body)) {
      for (const { event, data } of events) {
        if (event !== "progress") return last(event, data, response);
        const { progress: done, remaining_seconds: seconds } = JSON.parse(data);
        onProgress({ done, seconds });
      }
    }
  } catch (error) {
    if (request.signal.aborted) throw error;
    throw new OfflineError("cut off", { cause: error });
  }
  throw new OfflineError("cut off");
}

/** @param {string} event @param {string} data @param {Response} response */
function last(event, data, response) {
  const headers = new Headers(response.headers);
  headers.set("content-type", event === "problem" ? "application/problem+json" : "application/json");
  return new Response(data, { status: event === "problem" ? JSON.parse(data).status : response.status, headers });
}
