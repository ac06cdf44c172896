// Changes by another client appear on the open page, after a restart of the server, too.

import assert from "node:assert/strict";
import { browserTest, example } from "./harness.js";

/** Opens a page, and waits until it follows a job, or all. @param {import("./harness.js").World} world @param {string | undefined} id @param {string} place */
async function following({ page, open }, id, place) {
  const path = id === undefined ? "/v1/events" : `/v1/jobs/${id}/events`;
  const begun = page.waitForResponse((response) => response.url().endsWith(path));
  await open(place);
  await begun;
}

browserTest("the trace, the map and what comes of it follow another client", {}, async (world) => {
  const { page, job, iteration, call } = world;
  const { id } = await job();
  await iteration(id);
  const at = `/v1/jobs/${id}/iterations/1`;
  await following(world, id, `/jobs/${id}/trace`);
  const entries = page.locator(".trace-entry");
  const before = await entries.count();
  const made = await call("POST", `${at}/fits`, {
    ...JSON.parse(await example("requests/refit.json")),
    reason: "theirs",
  });
  await page.locator(`[data-entry="${made.id}"]`, { hasText: "theirs" }).waitFor();
  assert.equal(await entries.count(), before + 1);

  await following(world, id, `/jobs/${id}/iterations/1`);
  await call("PATCH", at, { decision: "remachine", reason: "seen elsewhere" });
  await page.getByText("seen elsewhere").waitFor();

  await following(world, id, `/jobs/${id}/iterations/1/lambda`);
  await call("PUT", `${at}/chosen-fit`, { fit_id: made.id, reason: "chosen by another" });
  const row = page.getByRole("row").filter({ hasText: "theirs" });
  await row.getByText("chosen", { exact: true }).waitFor();

  await following(world, id, `/jobs/${id}/iterations/1/correction`);
  await call("POST", `${at}/correction`, await example("requests/iteration_correction.json"));
  // records have no events of their own yet: the next measurement is one
  await iteration(id, "flank_z52_remachined.json");
  await page.locator("#answered").waitFor();
  await page.getByText("Measured with iteration 2").or(page.getByText("iteration 2")).first().waitFor();
});

browserTest("after a restart a trace and a stream are followed again", { offline: true }, async (world) => {
  const { page, open, server, job, iteration, call, startAgain } = world;
  const { id } = await job();
  await iteration(id);
  await open(`/jobs/${id}/trace`);
  await server.stop();
  await page.getByText("Not updated since").waitFor();
  const again = page.waitForResponse((response) => response.url().endsWith(`/v1/jobs/${id}/events`));
  await startAgain();
  await again;
  await call("PATCH", `/v1/jobs/${id}/iterations/1`, { decision: "rejected", reason: "after the restart" });
  await page.getByText("after the restart").waitFor();

  const { nodes, axes, model, regularization } = JSON.parse(await example("flank_z52.json"));
  const stream = await call("POST", `/v1/jobs/${id}/streams`, { model, regularization, axes });
  let sequence = 0;
  const send = (/** @type {number[]} */ rows) => {
    sequence += 1;
    const block = rows.flatMap((row) =>
      nodes.z[row].flatMap((/** @type {number | null} */ z, /** @type {number} */ column) =>
        z === null ? [] : [[nodes.u[row], nodes.v[column], z]],
      ),
    );
    const [u, v, z] = [0, 1, 2].map((k) => block.map((/** @type {number[]} */ one) => one[k]));
    return call("POST", `/v1/streams/${stream.id}/nodes`, { sequence, nodes: { type: "scattered", u, v, z } });
  };
  await send([0, 2, 4]);
  await open(`/jobs/${id}/streams/${stream.id}`);
  await page.locator('[data-sequence="1"]').waitFor();
  await server.stop();
  await page.getByText("Not updated since").waitFor();
  const followed = page.waitForResponse((response) => response.url().endsWith(`/v1/jobs/${id}/events`));
  await startAgain();
  await followed;
  await send([6, 8]);
  await page.locator('[data-sequence="2"]').waitFor();
});

browserTest("the list and its counts follow another client", { offline: true }, async (world) => {
  const { page, server, job, iteration, call, startAgain } = world;
  const { id } = await job({ name: "first of all" });
  await following(world, undefined, "/jobs");
  const row = (/** @type {string} */ name) => page.getByRole("row").filter({ hasText: name });
  const count = (/** @type {string} */ status, /** @type {number} */ of) =>
    page
      .locator(`.status-count${status}`, { hasText: `${of}` })
      .first()
      .waitFor();
  await row("first of all").getByText("new", { exact: true }).waitFor();
  await job({ name: "made elsewhere" });
  await row("made elsewhere").waitFor();
  await count(":not(.new, .open, .remachine, .accepted, .rejected)", 2);
  await count(".new", 2);
  await iteration(id);
  await row("first of all").getByText("open", { exact: true }).waitFor();
  await count(".new", 1);
  await call("PATCH", `/v1/jobs/${id}/iterations/1`, { decision: "accepted", reason: "good" });
  await row("first of all").getByText("accepted", { exact: true }).waitFor();
  await count(".accepted", 1);
  const [, first] = await page.getByRole("row").all();
  assert.match((await first?.textContent()) ?? "", /first of all/, "what has changed last is first");

  await server.stop();
  await page.getByText("Not updated since").waitFor();
  const again = page.waitForResponse((response) => response.url().endsWith("/v1/events"));
  await startAgain();
  await again;
  await job({ name: "after the restart" });
  await row("after the restart").waitFor();
  await count(".new", 2);
});

browserTest("the list waits while somebody types", { alone: true }, async (world) => {
  const { page, job } = world;
  await job({ name: "first of all" });
  await page.clock.install();
  await following(world, undefined, "/jobs");
  await page.clock.runFor(5000);
  await world.loaded();
  await page.getByLabel("Search").focus();
  let requests = 0;
  page.on("request", (request) => {
    if (request.url().includes("/v1/jobs?")) requests += 1;
  });
  await job({ name: "made meanwhile" });
  // the response to a request from now on comes after the event has gone out
  await page.evaluate(() => fetch("/v1/whoami").then((answer) => answer.text()));
  await page.clock.runFor(5000);
  assert.equal(requests, 0);
  await page.getByLabel("Search").blur();
  await page.getByRole("link", { name: "made meanwhile" }).waitFor();
});

browserTest("who looks away for 30 s is not kept up to date, and is once they look again", {}, async (world) => {
  const { page, job, iteration } = world;
  const { id } = await job();
  await page.clock.install();
  await following(world, id, `/jobs/${id}`);
  /** @type {string[]} */
  const ended = [];
  page.on("requestfailed", (request) => {
    if (request.url().endsWith("/events")) ended.push(request.failure()?.errorText ?? "");
  });
  const look = (/** @type {"hidden" | "visible"} */ state) =>
    page.evaluate((now) => {
      Object.defineProperty(document, "visibilityState", { configurable: true, get: () => now });
      document.dispatchEvent(new Event("visibilitychange"));
    }, state);
  // a short change of the tab ends nothing; time also passes by itself, so it is short
  await look("hidden");
  await page.clock.runFor(10_000);
  await look("visible");
  await page.clock.runFor(20_000);
  assert.deepEqual(ended, []);
  await look("hidden");
  const closed = page.waitForEvent("requestfailed", (request) => request.url().endsWith("/events"));
  await page.clock.runFor(31_000);
  await closed;
  assert.equal(ended.length, 1);
  await iteration(id);
  await page.clock.runFor(60_000);
  await page.getByText("appear here after the first measurement").waitFor();
  const again = page.waitForRequest((request) => request.url().endsWith("/events"));
  await look("visible");
  await again;
  await page.getByText("Decide on iteration 1").waitFor();
});
