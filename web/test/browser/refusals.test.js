// Failures, the places of their messages, and that no input is lost by them.

import assert from "node:assert/strict";
import { createHash } from "node:crypto";
import { browserTest, example } from "./harness.js";

/** Responds as a temporarily overloaded server. @param {import("playwright-core").Route} route @param {number} seconds */
function busy(route, seconds) {
  const body = { type: "about:blank", title: "Busy", status: 503, code: "overloaded", detail: "Busy." };
  return route.fulfill({
    status: 503,
    headers: { "retry-after": `${seconds}` },
    contentType: "application/problem+json",
    body: JSON.stringify(body),
  });
}

browserTest("the second of two who choose a fit sees the current choice", { statuses: [412] }, async (world) => {
  const { page, open, loaded, job, iteration, call } = world;
  const { id } = await job();
  const { fits } = await iteration(id);
  const at = `/v1/jobs/${id}/iterations/1`;
  const refit = JSON.parse(await example("requests/refit.json"));
  const [mine, theirs] = [await call("POST", `${at}/fits`, refit), await call("POST", `${at}/fits`, refit)];
  await open(`/jobs/${id}/iterations/1/lambda?fit=${mine.id}`);
  // the event of others' changes waits while a dialog is open
  const row = page.getByRole("row").filter({ hasText: "shown here" });
  await row.getByRole("button", { name: "Choose this fit" }).click();
  const dialog = page.getByRole("dialog");
  await dialog.getByLabel("Reason").fill("mine is better");
  await call("PUT", `${at}/chosen-fit`, { fit_id: theirs.id, reason: "theirs" });
  await dialog.getByRole("button", { name: "Choose this fit" }).click();
  await dialog.getByText("Changed by someone else in the meantime").waitFor();
  await dialog.getByText("Currently chosen").waitFor();
  assert.equal(await dialog.getByLabel("Reason").inputValue(), "mine is better");
  await dialog.getByRole("button", { name: "Choose this fit anyway" }).click();
  await page.getByText("This fit is now the chosen one.").waitFor();
  await loaded();
  const now = await call("GET", at);
  assert.equal(now.fits.find((/** @type {any} */ fit) => fit.chosen).id, mine.id);
  assert.notEqual(mine.id, fits[0].id);
});

browserTest(
  "what was typed outlives a refusal, a lost connection and a reload",
  { statuses: [503], offline: true },
  async (world) => {
    const { page, open, loaded, server, call } = world;
    await open("/jobs/new");
    await page.getByLabel("Name", { exact: true }).fill("kept through it all");
    await page.getByLabel("Teeth z").fill("52");
    await page.getByLabel("Normal module").fill("1,25");
    await page.route("**/v1/jobs", (route) =>
      route.request().method() === "POST" ? busy(route, 30) : route.continue(),
    );
    await page.getByRole("button", { name: "Create the job" }).click();
    await page.getByRole("button", { name: "Do not resend" }).click();
    await page.getByRole("heading", { name: "The server is overloaded" }).waitFor();
    await page.getByText("Try again after 30 s.").waitFor();
    await page.unroute("**/v1/jobs");
    await server.stop();
    let tries = 0;
    page.on("requestfailed", (request) => {
      if (request.method() === "POST") tries += 1;
    });
    await page.getByRole("button", { name: "Create the job" }).click();
    await page.getByRole("button", { name: "Do not resend" }).click();
    await page.locator(".new-job-fields").getByRole("heading", { name: "The server is not responding" }).waitFor();
    assert.ok(tries > 0 && tries < 5, `it was tried ${tries} times`);
    await server.start();
    await page.reload();
    await loaded();
    assert.equal(await page.getByLabel("Name", { exact: true }).inputValue(), "kept through it all");
    assert.equal(await page.getByLabel("Normal module").inputValue(), "1,25");
    await page.getByRole("button", { name: "Create the job" }).click();
    await page.getByRole("heading", { name: "kept through it all" }).waitFor();
    const { items } = await call("GET", "/v1/jobs");
    assert.deepEqual([items.length, items[0].gear.normal_module_mm], [1, 1.25]);
    // and sent input is not offered again
    await open("/jobs/new");
    assert.equal(await page.getByLabel("Name", { exact: true }).inputValue(), "");
  },
);

browserTest("reasons, corrections and edits outlive a reload", {}, async ({ page, open, loaded, job, iteration }) => {
  const { id } = await job();
  await iteration(id);
  await open(`/jobs/${id}/iterations/1`);
  await page.getByRole("button", { name: "Reject" }).click();
  await page.getByRole("dialog").getByLabel("Reason").fill("burnt at the tip");
  await page.reload();
  await loaded();
  await page.getByRole("button", { name: "Reject" }).click();
  assert.equal(await page.getByRole("dialog").getByLabel("Reason").inputValue(), "burnt at the tip");
  await page.keyboard.press("Escape");
  await open(`/jobs/${id}/iterations/1/correction`);
  await page.getByLabel("Target").selectOption("given");
  await page.getByLabel("Target deviations").fill("1 2 3");
  await open(`/jobs/${id}`);
  await page.getByRole("button", { name: "Edit" }).click();
  await page.getByRole("dialog").getByLabel("Machine").fill("another");
  await open(`/jobs/${id}/iterations/1/correction`);
  assert.equal(await page.getByLabel("Target deviations").inputValue(), "1 2 3");
  await open(`/jobs/${id}`);
  await page.getByRole("button", { name: "Edit" }).click();
  assert.equal(await page.getByRole("dialog").getByLabel("Machine").inputValue(), "another");
});

browserTest("nodes of a fit outlive a reload", {}, async ({ page, open, loaded }) => {
  await open("/fit");
  await page.getByLabel("Drop a file here").setInputFiles({
    name: "kept.json",
    mimeType: "application/json",
    buffer: Buffer.from(await example("flank_z52.json")),
  });
  await page.getByRole("heading", { name: "Figures of this fit" }).waitFor();
  await page.reload();
  await loaded();
  await page.getByRole("heading", { name: "Figures of this fit" }).waitFor();
  await page.getByText("kept.json").first().waitFor();
});

const KEY = "a-key-that-ends";
const serve = [`--api-keys-sha256=${createHash("sha256").update(KEY).digest("hex")}`, "--auth=required"];

browserTest("a request for a key in the middle of a form loses no input", { serve, statuses: [401] }, async (world) => {
  const { page, server, loaded, call } = world;
  await page.goto(`${server.url}/jobs/new`);
  const dialog = page.getByRole("dialog", { name: "API key" });
  await dialog.waitFor();
  await page.keyboard.press("Escape");
  await page.getByLabel("With gear data").uncheck();
  await page.getByLabel("Name", { exact: true }).fill("typed without a key");
  await page.getByRole("button", { name: "Create the job" }).click();
  await dialog.getByLabel("Key", { exact: true }).fill(KEY);
  await dialog.getByRole("button", { name: "Use this key" }).click();
  await loaded();
  assert.equal(await page.getByLabel("Name", { exact: true }).inputValue(), "typed without a key");
  await page.getByRole("button", { name: "Create the job" }).click();
  await page.getByRole("heading", { name: "typed without a key" }).waitFor();
  assert.equal((await call("GET", "/v1/jobs", undefined, { "x-api-key": KEY })).items.length, 1);
});

browserTest(
  "what a busy server has put off is sent again, under the same key, a few times",
  { statuses: [503], alone: true },
  async (world) => {
    const { page, open, call } = world;
    await page.clock.install();
    /** @type {(string | undefined)[]} */
    const keys = [];
    let refusals = 2;
    await page.route("**/v1/jobs", (route) => {
      if (route.request().method() !== "POST") return route.continue();
      keys.push(route.request().headers()["idempotency-key"]);
      return keys.length <= refusals ? busy(route, 50) : route.continue();
    });
    const again = page.getByText("Your input is queued and will be resent in 50 s.");
    const begin = async (/** @type {string} */ name) => {
      await open("/jobs/new");
      await page.getByLabel("With gear data").uncheck();
      await page.getByLabel("Name", { exact: true }).fill(name);
      await page.getByRole("button", { name: "Create the job" }).click();
      await again.waitFor();
    };
    await begin("put off");
    // time also passes by itself, so there is a wide margin
    await page.clock.runFor(20_000);
    assert.equal(keys.length, 1);
    await page.clock.runFor(31_000);
    await again.waitFor();
    const stored = page.getByRole("heading", { name: "put off" }).waitFor();
    await page.clock.runFor(51_000);
    await stored;
    assert.equal(keys.length, 3);
    assert.equal(new Set(keys).size, 1);
    assert.ok(keys[0]);
    assert.equal((await call("GET", "/v1/jobs")).items.length, 1);
    assert.equal(await again.count(), 0);

    // not without end
    refusals = Number.POSITIVE_INFINITY;
    keys.length = 0;
    await begin("never");
    for (let tries = 2; tries <= 5; tries += 1) {
      const sent = page.waitForRequest((request) => request.method() === "POST");
      await page.clock.runFor(51_000);
      await sent;
      if (tries < 5) await again.waitFor();
    }
    await page.getByRole("heading", { name: "The server is overloaded" }).waitFor();
    await page.getByText("Try again after 50 s.").waitFor();
    await page.clock.runFor(90_000);
    assert.deepEqual([keys.length, new Set(keys).size], [5, 1]);
    assert.equal(await page.getByLabel("Name", { exact: true }).inputValue(), "never");

    // and not against the will of the sender
    keys.length = 0;
    await page.getByRole("button", { name: "Create the job" }).click();
    await page.getByRole("button", { name: "Do not resend" }).click();
    await page.getByText("Try again after 50 s.").waitFor();
    await page.clock.runFor(90_000);
    assert.equal(keys.length, 1);
  },
);
