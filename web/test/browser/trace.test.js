// The story of a job.

import assert from "node:assert/strict";
import { formats } from "../../app/lib/format.js";
import { termSign } from "../../app/lib/terms.js";
import { browserTest, example } from "./harness.js";
import { unitOf } from "./numbers.js";

const f = formats("en");

browserTest("the trace has all events, in order, and compares two fits", {}, async (world) => {
  const { page, open, loaded, job, iteration, call } = world;
  const { id } = await job();
  await iteration(id);
  const at = `/v1/jobs/${id}/iterations/1`;
  const kept = await call("POST", `${at}/fits`, JSON.parse(await example("requests/refit.json")));
  await call("PUT", `${at}/chosen-fit`, { fit_id: kept.id, reason: "the error budget asks for it" });
  await call("POST", `${at}/correction`, JSON.parse(await example("requests/iteration_correction.json")));
  await call("PATCH", at, { decision: "remachine", reason: "beyond class 5" });
  await iteration(id, "flank_z52_remachined.json");
  /** @type {string[]} */
  const paths = [];
  page.on("request", (request) => {
    paths.push(new URL(request.url()).pathname);
  });
  await open(`/jobs/${id}/trace`);
  // the trace is complete: no iteration is requested in addition
  assert.deepEqual(
    paths.filter((path) => /iterations/.test(path)),
    [],
  );
  const { iterations } = await call("GET", `/v1/jobs/${id}/trace`);
  const [first, second] = iterations;
  const text = (await page.locator(".trace-entries").textContent()) ?? "";
  for (const word of [
    "the error budget asks for it",
    "beyond class 5",
    "machine again",
    "After the correction of iteration 1",
  ])
    assert.ok(text.includes(word), word);
  for (const fit of [...first.fits, ...second.fits]) {
    const entry = page.locator(`[data-entry="${fit.id}"]`);
    const figures = await entry.locator("dd").allTextContents();
    // figures of the flank come after these: requirements.test.js
    assert.deepEqual(figures.slice(0, 3), [
      f.three(fit.lambda_star),
      f.condition(fit.regularized_condition ?? fit.condition),
      `${f.three(fit.rms)} µm`,
    ]);
  }
  assert.match((await page.locator(".trace-links path").getAttribute("d")) ?? "", /^M/, "a line to the answer");
  // time goes downwards
  const tops = await page
    .locator(".trace-entry")
    .evaluateAll((all) => all.map((one) => one.getBoundingClientRect().top));
  assert.deepEqual(
    tops,
    [...tops].sort((a, b) => a - b),
  );

  const [a, b] = [first.fits.find((/** @type {any} */ one) => one.chosen), second.fits[0]];
  const rows = page.getByRole("table", { name: "Comparison of two fits" }).locator("tbody tr");
  for (const [i, one] of a.coefficients.entries()) {
    const other = b.coefficients.find((/** @type {any} */ c) => c.term === one.term);
    const cells = await rows.nth(i).locator(".cell").allTextContents();
    const difference = other.value - one.value;
    const unit = unitOf(one);
    assert.deepEqual(cells, [
      termSign(one.term),
      f.withError(one.value, one.std_error, unit),
      f.withError(other.value, other.std_error, unit),
      `${f.three(difference)}\u202f${unit}`,
      f.fixed(difference / Math.hypot(one.std_error, other.std_error), 1),
    ]);
  }
  await page.getByLabel("Records").uncheck();
  await page.reload();
  await loaded();
  assert.equal(await page.locator(".trace-entry.record").count(), 0);
  assert.equal(await page.getByLabel("Records").isChecked(), false);
});

browserTest("a job without a measurement has no story yet", {}, async ({ page, open, job }) => {
  const { id } = await job();
  await open(`/jobs/${id}/trace`);
  await page.getByText("appear here after the first measurement").waitFor();
});
