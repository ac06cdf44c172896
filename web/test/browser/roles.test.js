// Actions that a role lacks permission for are hidden; a refusal gives the reason.

import assert from "node:assert/strict";
import { createHash } from "node:crypto";
import { browserTest } from "./harness.js";

const KEY = "a-key-for-the-tests";
const as = (/** @type {string} */ role) => [
  `--api-keys-sha256=${createHash("sha256").update(KEY).digest("hex")}`,
  "--auth=required",
  `--api-keys-role=${role}`,
];

/** @param {import("./harness.js").World} world */
async function withKey({ page, server }) {
  await page.goto(`${server.url}/settings`);
  await page.evaluate((key) => sessionStorage.setItem("flankfit.key", key), KEY);
}

browserTest(
  "a reader is offered nothing that changes anything",
  { serve: as("reader"), statuses: [401, 404] },
  async (world) => {
    const { page, open, loaded } = world;
    await withKey(world);
    await open("/settings");
    await page.getByText("reader", { exact: true }).waitFor();
    await open("/jobs");
    assert.equal(await page.getByRole("link", { name: "New job" }).count(), 0);
    await page.getByRole("link", { name: "Fit", exact: true }).waitFor();
    await open("/jobs/new");
    await page.getByText("A key with the role “reader” may not measure or create jobs.").waitFor();
    assert.equal(await page.locator("main form").count(), 0);
    await page.getByRole("button", { name: "Use another key" }).click();
    await page.getByRole("dialog", { name: "API key" }).waitFor();
    await page.keyboard.press("Escape");
    await loaded();
  },
);

browserTest(
  "an operator measures, and an engineer decides",
  { serve: as("operator"), statuses: [401] },
  async (world) => {
    const { page, open, loaded, call } = world;
    const headers = { "x-api-key": KEY };
    const { id } = await call("POST", "/v1/jobs", { name: "guarded" }, headers);
    const nodes = {
      type: "grid",
      u: [1, 2, 3, 4],
      v: [1, 2, 3, 4],
      z: [1, 2, 3, 4].map((u) => [1, 2, 3, 4].map((v) => u * v)),
    };
    await call("POST", `/v1/jobs/${id}/iterations`, { nodes, model: { type: "polynomial", degree: 1 } }, headers);
    await withKey(world);
    await open(`/jobs/${id}`);
    await page.getByRole("navigation", { name: "Views of this job" }).getByRole("link", { name: "Measure" }).waitFor();
    assert.equal(await page.getByRole("button", { name: "Edit" }).count(), 0);
    await open(`/jobs/${id}/iterations/1`);
    await page.getByText("A key with the role “operator” may not decide or change jobs and fits.").waitFor();
    for (const name of ["Accept", "Machine again", "Reject"])
      assert.equal(await page.getByRole("button", { name, exact: true }).count(), 0);
    await open(`/jobs/${id}/iterations/1/lambda`);
    await page.getByRole("slider", { name: /manual/ }).waitFor();
    assert.equal(await page.getByRole("button", { name: "Store", exact: true }).count(), 0);
    await open(`/jobs/${id}/iterations/1/correction`);
    await page.getByText("may not decide").waitFor();
    assert.equal(await page.getByRole("button", { name: "Compute the correction" }).count(), 0);
    await loaded();
  },
);

browserTest("an auditor's pages request no computation", { serve: as("auditor"), statuses: [401] }, async (world) => {
  const { page, open } = world;
  await withKey(world);
  await open("/jobs");
  assert.equal(await page.getByRole("link", { name: "Fit", exact: true }).count(), 0);
  await open("/fit");
  await page.getByText("may not compute").waitFor();
});

browserTest("the trace says by whom", { serve: as("engineer"), statuses: [401] }, async (world) => {
  const { page, open, call } = world;
  const headers = { "x-api-key": KEY };
  const { id } = await call("POST", "/v1/jobs", { name: "guarded" }, headers);
  const [u, v] = [
    [1, 2, 3, 4],
    [1, 2, 3, 4],
  ];
  const nodes = { type: "grid", u, v, z: u?.map((a) => v?.map((b) => a * b)) };
  await call("POST", `/v1/jobs/${id}/iterations`, { nodes, model: { type: "polynomial", degree: 1 } }, headers);
  await call("PATCH", `/v1/jobs/${id}/iterations/1`, { decision: "accepted", reason: "good" }, headers);
  await withKey(world);
  await open(`/jobs/${id}/trace`);
  const { iterations } = await call("GET", `/v1/jobs/${id}/trace`, undefined, headers);
  const { decisions, fits } = iterations[0];
  assert.ok(decisions[0].by);
  const said = (/** @type {import("playwright-core").Locator} */ entry, /** @type {string} */ by) =>
    entry.getByText(`by ${by}`).waitFor();
  await said(page.locator('[data-entry="decision-1-0"]'), decisions[0].by);
  await said(page.locator(`[data-entry="${fits[0].id}"]`), fits[0].by);
});
