// A job: next step, iterations, changes, and failures.

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { browserTest, example } from "./harness.js";

browserTest(
  "iterations with their figures, and what is to be done next",
  {},
  async ({ page, open, job, iteration, call }) => {
    const { id } = await job();
    const first = await iteration(id);
    await call("PATCH", `/v1/jobs/${id}/iterations/1`, { decision: "remachine", reason: "slope" });
    await iteration(id, "flank_z52_remachined.json");
    await open(`/jobs/${id}`);
    await page.getByText("Decide on iteration 2").waitFor();
    const rows = page.getByRole("region", { name: "Iterations", exact: true }).locator("tbody tr");
    assert.equal(await rows.count(), 2);
    const { iterations } = await call("GET", `/v1/jobs/${id}/trace`);
    const fit = iterations[0].fits[0];
    const row = (await rows.nth(0).textContent()) ?? "";
    assert.ok(first && row.includes(fit.rms.toPrecision(3)), row);
    assert.match(row, /machine again/);
    assert.match(row, new RegExp(String(fit.condition.toPrecision(2)).split("e")[0] ?? "?"));
  },
);

browserTest(
  "limits are listed by flank, and figures outside them are red",
  {},
  async ({ page, open, job, iteration, call }) => {
    const limits = { profile_slope_um: [-6, 6], left: { helix_slope_um: [-6, 2] }, right: { helix_slope_um: [-2, 6] } };
    const { id } = await job({ requirements: { tolerance_limits: limits } });
    await iteration(id);
    await iteration(id, "flank_z52_right.json");
    await open(`/jobs/${id}`);
    const rows = page.getByRole("table", { name: "Slopes, crownings, twist" }).locator("tbody tr");
    const cells = async (/** @type {number} */ row) => rows.nth(row).locator(".cell").allTextContents();
    assert.deepEqual((await cells(2)).slice(0, 3), ["Limits, left", "−6 … 6", "−6 … 2"]);
    assert.deepEqual((await cells(3)).slice(0, 3), ["Limits, right", "−6 … 6", "−2 … 6"]);
    const { iterations } = await call("GET", `/v1/jobs/${id}/trace`);
    const outside = iterations.map((/** @type {any} */ { fits }) => fits[0].figures.profile_slope_um.within);
    assert.deepEqual(outside, [false, false]);
    for (const row of [0, 1]) assert.equal(await rows.nth(row).locator(".strip.out").count(), 1, "f_Hα alone");
  },
);

browserTest("German has its words in a table's file", { settings: { language: "de" } }, async (world) => {
  const { page, open, job, iteration, call } = world;
  const { id } = await job();
  await iteration(id);
  await call("PATCH", `/v1/jobs/${id}/iterations/1`, { decision: "remachine", reason: "slope" });
  await open(`/jobs/${id}`);
  const waiting = page.waitForEvent("download");
  await page.getByRole("region", { name: "Iterationen", exact: true }).getByRole("button", { name: "CSV" }).click();
  const [head = "", first = ""] = (await readFile(await (await waiting).path(), "utf8")).split("\r\n");
  const of = (/** @type {string} */ name) => first.split(";")[head.split(";").indexOf(name)];
  assert.deepEqual([of("Flanke, Zahn"), of("Entscheidung")], ["links", "nacharbeiten"]);
});

browserTest("a change by somebody else shows both versions", { statuses: [412] }, async ({ page, open, job, call }) => {
  const { id } = await job();
  await open(`/jobs/${id}`);
  await page.getByRole("button", { name: "Edit" }).click();
  await page.getByLabel("Machine").fill("mine");
  await call("PATCH", `/v1/jobs/${id}`, { machine: "theirs", serial_number: "S-99" });
  await page.getByRole("button", { name: "Save" }).click();
  await page.getByText("Someone else has changed this job in the meantime. Both versions:").waitFor();
  const rows = page.getByRole("dialog").getByRole("row");
  assert.deepEqual(await rows.nth(1).locator(".cell").allTextContents(), ["Serial number", "unchanged", "S-99"]);
  assert.deepEqual(await rows.nth(2).locator(".cell").allTextContents(), ["Machine", "mine", "theirs"]);
  assert.equal(await rows.count(), 3, "only what differs");
  await page.getByRole("button", { name: "Overwrite with mine" }).click();
  await page.getByText("The job has been changed.").waitFor();
  const saved = await call("GET", `/v1/jobs/${id}`);
  assert.deepEqual([saved.machine, saved.serial_number], ["mine", "S-99"], "what only they changed stays theirs");
  await page.getByText("mine", { exact: true }).first().waitFor();
});

browserTest("a gear changes, and fields go away", {}, async ({ page, open, job, call }) => {
  const { id } = await job();
  await open(`/jobs/${id}`);
  await page.getByRole("button", { name: "Edit" }).click();
  await page.getByLabel("Serial number").fill("");
  await page.getByLabel("Face width").fill("16,5");
  await page.getByRole("button", { name: "Save" }).click();
  await page.getByText("The job has been changed.").waitFor();
  const stored = await call("GET", `/v1/jobs/${id}`);
  assert.deepEqual(
    [stored.serial_number, stored.gear.face_width_mm, stored.gear.tip_diameter_mm],
    [undefined, 16.5, 54.0219],
  );
});

browserTest("an error in a folded section opens it", {}, async ({ page, open, job }) => {
  const { id } = await job();
  await open(`/jobs/${id}`);
  await page.getByRole("button", { name: "Edit" }).click();
  const field = page.getByLabel("Twist, Right flank, to");
  await page.getByText("Limits of one flank").click();
  await field.fill("some");
  await page.getByText("Limits of one flank").click();
  await field.waitFor({ state: "hidden" });
  await page.getByRole("button", { name: "Save" }).click();
  await field.waitFor();
  const row = page.getByRole("group", { name: "Twist", exact: true }).last();
  await row.locator("input:focus").waitFor();
});

browserTest("only a job without iterations is deleted", { alone: true }, async ({ page, open, job, iteration }) => {
  const kept = await job({ name: "kept" });
  await iteration(kept.id);
  await open(`/jobs/${kept.id}`);
  assert.equal(await page.getByRole("button", { name: "Delete" }).count(), 0);
  const { id } = await job({ name: "empty" });
  await open(`/jobs/${id}`);
  await page.getByRole("button", { name: "Delete" }).click();
  await page.getByRole("dialog").getByRole("button", { name: "Delete" }).click();
  await page.getByText("The job has been deleted.").waitFor();
  await page.getByText("kept", { exact: true }).waitFor();
  assert.equal(await page.getByText("empty", { exact: true }).count(), 0);
});

browserTest("a job that is not there has a way back", { statuses: [404] }, async ({ page, open }) => {
  await open("/jobs/0190b0de-0000-7000-8000-000000000000");
  await page.getByRole("heading", { name: "Not found" }).waitFor();
  assert.match((await page.getByRole("alert").textContent()) ?? "", /Request/);
  await page.getByRole("link", { name: "Back to jobs" }).click();
  await page.getByRole("heading", { name: "Jobs" }).waitFor();
});

browserTest("a busy server is tried again when it says so", { statuses: [503] }, async ({ page, open, job }) => {
  const { id } = await job();
  let refused = 0;
  await page.clock.install();
  await page.route(`**/v1/jobs/${id}`, async (route) => {
    refused += 1;
    if (refused > 1) return route.continue();
    const body = {
      type: "urn:flankfit:problem:overloaded",
      title: "Busy",
      status: 503,
      code: "overloaded",
      detail: "Every worker is busy.",
    };
    return route.fulfill({
      status: 503,
      headers: { "retry-after": "70" },
      contentType: "application/problem+json",
      body: JSON.stringify(body),
    });
  });
  await open(`/jobs/${id}`);
  await page.getByText("Retrying in 70 s.").waitFor();
  // time also passes by itself, so that less than all of it may be enough
  await page.clock.runFor(40_000);
  assert.equal(refused, 1);
  await page.clock.runFor(31_000);
  await page.getByRole("heading", { name: "Pump gear, finish grinding" }).waitFor();
  assert.ok(refused >= 2);
});

browserTest(
  "without a server what was loaded stays, and comes alive again",
  { offline: true },
  async ({ page, open, job, server, startAgain }) => {
    const { id } = await job({ name: "stays" });
    await open("/jobs");
    await page.getByText("stays", { exact: true }).waitFor();
    await server.stop();
    await page.getByRole("link", { name: "Settings" }).click();
    await page.getByText(/Not updated since \d\d:\d\d:\d\d/).waitFor();
    const request = page.waitForRequest((request) => request.url().endsWith("/healthz"));
    await page.getByRole("button", { name: "Retry now" }).click();
    await request;
    await page.getByRole("link", { name: "Jobs", exact: true }).click();
    await page.getByText("stays", { exact: true }).waitFor();
    await startAgain();
    await page.getByRole("link", { name: "stays" }).click();
    await page.waitForURL(`**/jobs/${id}`);
    await page.getByText("appear here after the first measurement").waitFor();
  },
);

browserTest(
  "what others do is shown as it happens, but not while somebody types",
  {},
  async ({ page, open, job, iteration, call }) => {
    const { id } = await job();
    const begun = page.waitForResponse((response) => response.url().endsWith(`/v1/jobs/${id}/events`));
    await open(`/jobs/${id}`);
    await begun;
    await page.getByText("appear here after the first measurement").waitFor();
    await iteration(id);
    await page.getByText("Decide on iteration 1").waitFor();
    await page.getByRole("button", { name: "Edit" }).click();
    await page.getByLabel("Machine").fill("mine");
    const seen = page.waitForResponse((response) => response.url().includes(`/v1/jobs/${id}/trace`));
    let requests = 0;
    page.on("request", (request) => {
      if (request.url().includes(`/v1/jobs/${id}/trace`)) requests += 1;
    });
    await call("PATCH", `/v1/jobs/${id}/iterations/1`, { decision: "accepted", reason: "good" });
    // the response to a request from now on comes after the event has gone out
    await page.evaluate((place) => fetch(place).then((answer) => answer.text()), `/v1/jobs/${id}`);
    assert.equal(requests, 0);
    await page.keyboard.press("Escape");
    await seen;
    await page.getByText("Iteration 1 is accepted").waitFor();
  },
);

browserTest(
  "after a restart the page follows again",
  { offline: true },
  async ({ page, open, job, iteration, server, startAgain }) => {
    const { id } = await job();
    await open(`/jobs/${id}`);
    await page.getByText("appear here after the first measurement").waitFor();
    await server.stop();
    await page.getByText("Not updated since").waitFor();
    await startAgain();
    await iteration(id);
    await page.getByText("Decide on iteration 1").waitFor();
  },
);

browserTest("what lies outside its limits is named first, on the job and on its iteration", {}, async (world) => {
  const { page, open, job, iteration, call } = world;
  const { requirements } = JSON.parse(await example("requests/job_requirements.json"));
  const { id } = await job({ requirements });
  await iteration(id);
  const { fits } = await call("GET", `/v1/jobs/${id}/iterations/1`);
  const figures = Object.entries(fits[0].figures).filter(([name]) => name.endsWith("_um"));
  const outside = figures.filter(([, one]) => one.within === false);
  assert.ok(outside.length > 0 && outside.length < figures.length);
  await open(`/jobs/${id}`);
  await page.getByText("these figures are outside their limits").waitFor();
  assert.equal(await page.locator(".next-figures li").count(), outside.length);
  await page.getByRole("link", { name: "Correct", exact: true }).waitFor();
  await page.getByRole("link", { name: "Check the map and decide" }).click();
  const tiles = page.getByRole("list", { name: "Slopes, crownings, twist" }).locator("li");
  await tiles.first().waitFor();
  assert.equal(await tiles.count(), figures.length);
  assert.equal(await tiles.filter({ hasText: "✗" }).count(), outside.length);
  // tiles above the map, and no warning that every fit has
  const [first, map] = [await tiles.first().boundingBox(), await page.locator(".heat-map").first().boundingBox()];
  assert.ok(first && map && first.y < map.y);
  assert.equal(await page.getByText("norm_limit_is_estimate").count(), 0);
  await open(`/jobs/${id}/iterations/1/statistics`);
  await page.getByText("norm_limit_is_estimate").waitFor();
});

browserTest(
  "where nothing is yet, a sentence says what will be and a primary action leads there",
  {},
  async (world) => {
    const { page, open, loaded, job, iteration, call } = world;
    const { id } = await job();
    const measure = `/jobs/${id}/measure`;
    const leads = async (/** @type {string} */ place, /** @type {string} */ text) => {
      await open(`/jobs/${id}${place}`);
      const empty = page.locator(".empty", { hasText: text });
      const action = empty.locator(".button.primary");
      assert.deepEqual(await action.allTextContents(), ["Measure"], place);
      assert.equal(await action.getAttribute("href"), measure, place);
      assert.equal(await page.locator(".empty").count(), 1, place);
    };
    await leads("", "of each iteration appear here after the first measurement");
    await leads("/trace", "appear here after the first measurement");
    await leads("/report", "The report appears here");
    await page.locator(".empty .button").click();
    await page.waitForURL(`**${measure}`);
    await loaded();
    await iteration(id);
    const evaluation = "/iterations/1/evaluation";
    await leads(evaluation, "Evaluated profiles, helices and pitches appear here");
    await open(`/jobs/${id}/iterations/1/correction`);
    await page.getByText("appear here once they have been computed").waitFor();
    assert.equal(await page.locator("main .button.primary").count(), 1, "computes them");
    await call("POST", `/v1/jobs/${id}/iterations/1/evaluations`, await example("requests/gear_evaluate.json"));
    await leads(evaluation, "Pitches and run-out appear here");
  },
);

browserTest("pitches without evaluated traces have a page of their own kind", {}, async (world) => {
  const { page, open, job, iteration, call } = world;
  const { id } = await job();
  await iteration(id);
  await call("POST", `/v1/jobs/${id}/iterations/1/pitch`, await example("requests/iteration_pitch.json"));
  await open(`/jobs/${id}/iterations/1/evaluation`);
  await page.locator(".empty", { hasText: "Evaluated profiles and helices appear here" }).waitFor();
  await page.getByRole("heading", { name: "Pitch and run-out" }).waitFor();
});
