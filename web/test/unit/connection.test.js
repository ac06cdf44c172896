// What is sent again, and what is not; when a page counts as live again.

import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";

/** @type {Map<string, string>} */
const kept = new Map();
const storage = {
  getItem: (/** @type {string} */ name) => kept.get(name) ?? null,
  setItem: (/** @type {string} */ name, /** @type {string} */ value) => kept.set(name, value),
  removeItem: (/** @type {string} */ name) => kept.delete(name),
};
Object.assign(globalThis, { sessionStorage: storage, localStorage: storage });

const { transport } = await import("../../app/api/client.js");
const { lostAt, probe, sendAgain } = await import("../../app/api/connection.js");
const { session } = await import("../../app/api/key.js");

/** @typedef {{ status: number, key: string | null, body: string }} Sent */
/** @type {Sent[]} */
let sent = [];
/** What the server answers, one after the other, and then 201. @type {{ status: number, after?: string, proxy?: boolean }[]} */
let answers = [];

globalThis.fetch = async (/** @type {RequestInfo | URL} */ input) => {
  const { status, after, proxy } = answers.shift() ?? { status: 201 };
  if (input instanceof Request)
    sent.push({ status, key: input.headers.get("x-api-key"), body: await input.clone().text() });
  const type = proxy ? "text/html" : status < 400 ? "application/json" : "application/problem+json";
  return new Response("{}", { status, headers: { "content-type": type, ...(after ? { "retry-after": after } : {}) } });
};

const decision = (/** @type {Record<string, string>} */ headers = { "idempotency-key": "k" }) =>
  new Request("http://server/v1/jobs/1", { method: "POST", body: "accept", headers });

beforeEach(() => {
  kept.clear();
  [sent, answers] = [[], []];
});

test("what is put off, or still done, is sent again as it was", async () => {
  answers = [
    { status: 503, after: "0" },
    { status: 409, after: "0" },
  ];
  const response = await sendAgain(decision(), transport);
  assert.equal(response.status, 201);
  assert.deepEqual(
    sent.map(({ status, body }) => [status, body]),
    [
      [503, "accept"],
      [409, "accept"],
      [201, "accept"],
    ],
  );
});

test("a refusal, and what has no key of its own, is sent once", async () => {
  answers = [{ status: 409 }];
  assert.equal((await sendAgain(decision(), transport)).status, 409);
  answers = [{ status: 503, after: "0" }];
  assert.equal((await sendAgain(decision({}), transport)).status, 503);
  assert.equal(sent.length, 2);
});

test("what somebody has sent is not sent with the key of another", async () => {
  kept.set("flankfit.key", "of A");
  answers = [{ status: 503, after: "0" }];
  // another key is taken before anything else can happen
  const response = await sendAgain(decision(), async (request) => {
    const answered = await transport(request);
    kept.set("flankfit.key", "of B");
    return answered;
  });
  assert.equal(response.status, 503);
  assert.deepEqual(
    sent.map(({ key }) => key),
    ["of A"],
  );
});

test("behind a proxy a page is live again once a server says so, and not by some other answer", async () => {
  const before = session.value;
  answers = [{ status: 502, proxy: true }];
  await assert.rejects(transport(new Request("http://server/v1/jobs")));
  assert.ok(lostAt.value);
  await transport(new Request("http://server/v1/machines"));
  assert.ok(lostAt.value, "one of them answers, another does not");
  assert.equal(session.value, before, "nothing is asked for anew");
  answers = [{ status: 200 }];
  assert.ok(await probe());
  assert.equal(lostAt.value, null);
  assert.equal(session.value, before + 1);
});
