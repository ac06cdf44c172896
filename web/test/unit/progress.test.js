// Responses with progress: they equal those of the plain request.

import assert from "node:assert/strict";
import { test } from "node:test";

const storage = { getItem: () => null, setItem: () => {}, removeItem: () => {} };
Object.assign(globalThis, { sessionStorage: storage, localStorage: storage });

const { withProgress } = await import("../../app/api/progress.js");
const { OfflineError } = await import("../../app/api/problem.js");

/** The response of the server. @type {(request: Request) => Response} */
let respond;
globalThis.fetch = async (/** @type {RequestInfo | URL} */ input) =>
  input instanceof Request ? respond(input) : new Response("{}");

/** @param {string} text */
const events = (text) => new Response(text, { headers: { "content-type": "text/event-stream", "x-request-id": "r" } });

const PROGRESS = 'event: progress\ndata: {"progress":0.25,"remaining_seconds":3}\n\n: quiet\n\n';

/** @param {HeadersInit} [headers] */
async function sent(headers) {
  /** @type {{ done: number, seconds: number | undefined }[]} */
  const seen = [];
  const send = withProgress((progress) => seen.push(progress));
  const response = await send(
    new Request("http://server/v1/fits", { method: "POST", body: "{}", ...(headers ? { headers } : {}) }),
  );
  return { seen, response };
}

test("progress is reported, and the result is the response", async () => {
  respond = (request) => {
    assert.equal(request.headers.get("accept"), "text/event-stream");
    return events(`${PROGRESS}event: result\ndata: {"number":1}\n\n`);
  };
  const { seen, response } = await sent();
  assert.deepEqual(seen, [{ done: 0.25, seconds: 3 }]);
  assert.deepEqual([response.status, await response.json()], [200, { number: 1 }]);
});

test("a problem has its own status, at once or as the last event", async () => {
  const problem = JSON.stringify({ status: 422, code: "not_converged" });
  respond = () => events(`${PROGRESS}event: problem\ndata: ${problem}\n\n`);
  const { response } = await sent();
  assert.deepEqual([response.status, response.headers.get("x-request-id")], [422, "r"]);
  assert.equal(response.headers.get("content-type"), "application/problem+json");
  assert.equal(await response.text(), problem);
  respond = () => new Response(problem, { status: 422 });
  assert.equal((await sent()).response.status, 422);
});

test("a response that is cut off counts as lost, and is requested again under the same key", async () => {
  respond = () => events(PROGRESS);
  await assert.rejects(sent(), OfflineError);
  let tries = 0;
  respond = () => {
    tries += 1;
    return events(tries === 1 ? PROGRESS : "event: result\ndata: 7\n\n");
  };
  const { response } = await sent({ "idempotency-key": "k" });
  assert.deepEqual([tries, await response.json()], [2, 7]);
});
