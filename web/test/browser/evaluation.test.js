// Evaluated traces as tester sheets.

import assert from "node:assert/strict";
import { browserTest, example } from "./harness.js";
import { agrees } from "./numbers.js";

const posted = async () => JSON.parse(await example("requests/gear_evaluate.json"));
/** @param {string} id */
const pathOf = (id) => `/jobs/${id}/iterations/1/evaluation`;

browserTest("the figures of a sheet are the interface's, and a class brings band and tolerances", {}, async (world) => {
  const { page, open, stands, job, iteration, call } = world;
  const { id } = await job();
  await iteration(id);
  await open(pathOf(id));
  await page.getByText("No traces of this iteration have been evaluated").waitFor();
  const record = await call("POST", `/v1/jobs/${id}/iterations/1/evaluations`, await posted());
  await page.reload();
  await page.getByRole("heading", { name: "Profiles" }).waitFor();
  await stands();
  assert.equal(await page.locator(".k-chart").count(), 3);
  assert.equal(await page.locator(".k-band").count(), 0, "no band without a class");
  for (const { kind, name } of [
    { kind: "profile", name: "Profiles" },
    { kind: "helix", name: "Helices" },
  ]) {
    const rows = page.getByRole("table", { name }).locator("tbody tr");
    const traces = record.result.traces.filter((/** @type {any} */ one) => one.kind === kind);
    for (const [i, trace] of traces.entries()) {
      const cells = rows.nth(i).locator("td .cell");
      agrees(await cells.nth(1).textContent(), trace.slope_um);
      // a column of intervals stands where some trace has one
      const after = traces.some((/** @type {any} */ one) => one.slope_interval_um) ? 4 : 3;
      agrees(await cells.nth(after).textContent(), trace.form_um);
      agrees(await cells.nth(after + 1).textContent(), trace.total_um);
      agrees(await cells.nth(after + 2).textContent(), trace.crowning_um);
    }
    const mean = record.result.means.find((/** @type {any} */ one) => one.kind === kind);
    agrees(await rows.nth(traces.length).locator("td .cell").nth(1).textContent(), mean.slope_um.mean);
  }
  await page.getByText("material grows towards the tip").first().waitFor();
  await page.getByText("turned towards the left hand").waitFor();

  await page.getByLabel("Class of the K-band").selectOption("3");
  await page.locator(".k-band").first().waitFor();
  const { gear } = await posted();
  const tolerances = await call("POST", "/v1/gears/tolerances", { gear, class: 3 });
  const row = page.getByRole("table", { name: "Profiles" }).locator("tbody tr", { hasText: "Tolerance, class 3" });
  agrees(await row.locator("td .cell").nth(1).textContent(), tolerances.rounded.profile_slope_um);
  agrees(await row.locator("td .cell").nth(5).textContent(), tolerances.rounded.profile_total_um);
  await page.locator(".k-outside-line").first().waitFor();
  await page.reload();
  await page.locator(".k-band").first().waitFor();
});

browserTest("other ranges and a class to conform to make another evaluation", { statuses: [422] }, async (world) => {
  const { page, open, stands, job, iteration, call } = world;
  const { id } = await job();
  await iteration(id);
  await call("POST", `/v1/jobs/${id}/iterations/1/evaluations`, await posted());
  await open(pathOf(id));
  await page.getByText("Evaluate with other ranges, sign or class").click();
  await page.getByLabel("Helix range from").fill("20");
  await page.getByRole("button", { name: "Evaluate", exact: true }).click();
  await page.locator("form .fault, form .failure").first().waitFor();
  assert.equal(await page.getByLabel("Helix range from").inputValue(), "20");
  await page.getByLabel("Helix range from").fill("1,5");
  await page.getByLabel("Class to conform to").selectOption("6");
  await page.getByRole("button", { name: "Evaluate", exact: true }).click();
  await page
    .locator(".badge", { hasText: /conforms|conform|told/ })
    .first()
    .waitFor();
  await stands();
  const { items } = await call("GET", `/v1/jobs/${id}/iterations/1/records`);
  assert.equal(items.length, 2);
  const last = await call("GET", `/v1/jobs/${id}/iterations/1/records/${items[1].id}`);
  assert.deepEqual(last.request.evaluation.helix_range_mm, [1.5, 14.25]);
  const decision = last.result.traces[0].slope_conformity.decision;
  const words = { conforms: "conforms", does_not_conform: "does not conform", cannot_be_told: "cannot be told" };
  const cell = page.getByRole("table", { name: "Profiles" }).locator("tbody tr").first().locator(".badge");
  assert.equal((await cell.textContent())?.trim(), words[/** @type {"conforms"} */ (decision)]);
  assert.equal(new URL(page.url()).searchParams.get("record"), items[1].id);
});

browserTest(
  "charts lie flat on a narrow screen",
  { context: { viewport: { width: 700, height: 900 } } },
  async (world) => {
    const { page, open, job, iteration, call } = world;
    const { id } = await job();
    await iteration(id);
    await call("POST", `/v1/jobs/${id}/iterations/1/evaluations`, await posted());
    await open(pathOf(id));
    const shape = async () => {
      const box = await page.locator(".k-chart").first().boundingBox();
      return (box?.width ?? 0) > (box?.height ?? 0);
    };
    assert.equal(await shape(), true);
    await page.setViewportSize({ width: 1280, height: 900 });
    await page.waitForFunction(() => {
      const box = document.querySelector(".k-chart")?.getBoundingClientRect();
      return box && box.height > box.width;
    });
  },
);
