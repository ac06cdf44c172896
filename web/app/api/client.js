// The only way to the server. Every request goes through `transport`, which adds the key and turns
// failures into errors that pages can show.
//
//     const { data, etag } = await answer(api.GET("/v1/jobs/{job_id}", { params: { path: { job_id } } }));

import { createClient } from "../../vendor/api.js";
import { connected, disconnected, isOfProxy, sendAgain } from "./connection.js";
import { currentKey, keyWanted } from "./key.js";
import { ApiError, OfflineError, unexplained } from "./problem.js";

/** @typedef {import("./schema.d.ts").paths} Paths */
/** @typedef {import("./schema.d.ts").components["schemas"]} Schemas */
/**
 * @template {keyof Schemas} Name
 * @typedef {Schemas[Name]} Schema
 */

/** @type {import("../../vendor/api.js").Client<Paths>} */
export const api = createClient({
  baseUrl: "",
  fetch: (request) => sendAgain(request, transport),
  querySerializer: { array: { style: "form", explode: false } },
});

/**
 * Sends a request with the key, and throws if there is no response. For requests that `api` cannot
 * make, such as event streams and files.
 * @param {Request} request
 */
export async function transport(request) {
  const key = currentKey();
  if (key) request.headers.set("x-api-key", key);
  /** @type {Response} */
  let response;
  try {
    response = await fetch(request);
  } catch (error) {
    if (request.signal.aborted) throw error;
    disconnected();
    throw new OfflineError("no answer", { cause: error });
  }
  if (isOfProxy(response)) {
    disconnected(true);
    throw new OfflineError("no answer", { cause: response.status });
  }
  connected();
  return response;
}

/**
 * Returns the data of a response and its tag; throws `ApiError` for a refusal. Progress events are
 * excluded.
 * @template Data
 * @param {Promise<{ data?: Data, error?: unknown, response: Response }>} pending
 * @returns {Promise<{ data: Exclude<Data, Schema<"Progress">>, etag: string | undefined, response: Response }>}
 */
export async function answer(pending) {
  const { data, error, response } = await pending.catch(cutOff);
  if (!response.ok) throw refusal(error, response);
  return {
    data: /** @type {Exclude<Data, Schema<"Progress">>} */ (data),
    etag: response.headers.get("etag") ?? undefined,
    response,
  };
}

/** Treats a response that was cut off as lost. @param {unknown} error @returns {never} */
function cutOff(error) {
  throw error instanceof TypeError ? new OfflineError("cut off", { cause: error }) : error;
}

/** @param {unknown} body @param {Response} response */
export function refusal(body, response) {
  const isProblem = typeof body === "object" && body !== null && "code" in body;
  const problem = isProblem ? /** @type {Schema<"Problem">} */ (body) : unexplained(response);
  if (response.status === 401) keyWanted.value = "unauthorized";
  else if (response.status === 403 && problem.code === "forbidden") keyWanted.value = "forbidden";
  return new ApiError(problem, response);
}
