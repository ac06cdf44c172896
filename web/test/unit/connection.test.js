// Resending of requests, and its limits; the end of an outage.

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

const { answer, transport } = await import("../../app/api/client.js");
const { lostAt, probe, sendAgain } = await import("../../app/api/connection.js");
const { session } = await import("../../app/api/key.js");
const { ApiError, OfflineError } = await import("../../app/api/problem.js");

/** @typedef {{ status: number, key: string | null, body: string }} Sent */
/** @type {Sent[]} */
let sent = [];
/** The responses of the server, one after the other, and then 201; 0: none. @type {{ status: number, after?: string, proxy?: boolean }[]} */
let answers = [];
let alive = false;

globalThis.fetch = async (/** @type {RequestInfo | URL} */ input) => {
  // the server is polled until it responds
  if (!(input instanceof Request)) return new Response("{}", { status: alive ? 200 : 502 });
  const { status, after, proxy } = answers.shift() ?? { status: 201 };
  sent.push({ status, key: input.headers.get("x-api-key"), body: await input.clone().text() });
  if (status === 0) throw new TypeError("the connection was closed");
  const type = proxy ? "text/html" : status < 400 ? "application/json" : "application/problem+json";
  return new Response("{}", { status, headers: { "content-type": type, ...(after ? { "retry-after": after } : {}) } });
};

const decision = (/** @type {Record<string, string>} */ headers = { "idempotency-key": "k" }) =>
  new Request("http://server/v1/jobs/1", { method: "POST", body: "accept", headers });

/** Sent requests, and their responses. */
const tried = () => sent.map(({ status, body }) => [status, body]);

beforeEach(() => {
  kept.clear();
  alive = false;
  [sent, answers] = [[], []];
});

test("what is put off, or still done, is sent again as it was", async () => {
  answers = [
    { status: 503, after: "0" },
    { status: 409, after: "0" },
  ];
  const response = await sendAgain(decision(), transport);
  assert.equal(response.status, 201);
  assert.deepEqual(tried(), [
    [503, "accept"],
    [409, "accept"],
    [201, "accept"],
  ]);
});

test("a request without a response is sent again unchanged, with a report of a proxy or without", async () => {
  answers = [{ status: 0 }, { status: 502, proxy: true }];
  const response = await sendAgain(decision(), transport);
  assert.equal(response.status, 201);
  assert.deepEqual(tried(), [
    [0, "accept"],
    [502, "accept"],
    [201, "accept"],
  ]);
  answers = [{ status: 0 }];
  await assert.rejects(sendAgain(decision({}), transport), OfflineError);
});

test("it is tried five times, and not for longer than a minute", async (t) => {
  t.mock.timers.enable({ apis: ["setTimeout"] });
  const now = t.mock.method(performance, "now", () => 0);
  const sends = async () => {
    const outcome = assert.rejects(sendAgain(decision(), transport), OfflineError);
    // each pause, and pending work
    for (let i = 0; i < 100; i += 1) {
      await new Promise((resolve) => setImmediate(resolve));
      t.mock.timers.tick(1000);
    }
    await outcome;
    return sent.splice(0).length;
  };
  answers = Array.from({ length: 9 }, () => ({ status: 0 }));
  assert.equal(await sends(), 5);
  // each try takes half a minute
  let time = 0;
  now.mock.mockImplementation(() => {
    time += 31_000;
    return time;
  });
  answers = Array.from({ length: 9 }, () => ({ status: 0 }));
  const slow = await sends();
  assert.ok(slow > 1 && slow < 5, `${slow}`);
});

test("what the server still does is waited for longer and longer, whatever it says", async (t) => {
  t.mock.timers.enable({ apis: ["setTimeout"] });
  answers = Array.from({ length: 4 }, () => ({ status: 409, after: "1" }));
  const outcome = sendAgain(decision(), transport);
  /** @type {number[]} */
  const at = [];
  for (let second = 0; second <= 20; second += 1) {
    for (let i = 0; i < 5; i += 1) await new Promise((resolve) => setImmediate(resolve));
    while (at.length < sent.length) at.push(second);
    t.mock.timers.tick(1000);
  }
  assert.equal((await outcome).status, 201);
  assert.deepEqual(at, [0, 1, 3, 7, 15]);
});

test("an answer that is cut off is none, and a refusal is one", async () => {
  await assert.rejects(answer(Promise.reject(new TypeError("terminated"))), OfflineError);
  const aborted = new DOMException("stopped", "AbortError");
  await assert.rejects(answer(Promise.reject(aborted)), (error) => error === aborted);
  const refused = { error: { code: "conflict", title: "" }, response: new Response("{}", { status: 409 }) };
  await assert.rejects(answer(Promise.resolve(refused)), ApiError);
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
  assert.ok(lostAt.value, "one of them responds, another does not");
  assert.equal(session.value, before, "nothing is reloaded");
  alive = true;
  assert.ok(await probe());
  assert.equal(lostAt.value, null);
  assert.equal(session.value, before + 1);
});
