// Statistics of a fit.

import assert from "node:assert/strict";
import { formats } from "../../app/lib/format.js";
import { browserTest } from "./harness.js";
import { termSign } from "../../app/lib/terms.js";

const f = formats("en");

browserTest("spectrum, collinearity, residuals and replay are the interface's own", {}, async (world) => {
  const { page, open, loaded, job, iteration } = world;
  const { id } = await job();
  const { fits } = await iteration(id);
  const { result } = fits[0];
  await open(`/jobs/${id}/iterations/1/statistics`);
  const rowsOf = async (/** @type {string} */ name) =>
    page
      .getByRole("table", { name })
      .locator("tbody tr")
      .evaluateAll((all) => all.map((row) => [...row.querySelectorAll(".cell")].map((one) => one.textContent)));
  assert.deepEqual(
    await rowsOf("Variance inflation factors"),
    result.collinearity.columns.map((/** @type {any} */ { term, vif }) => [termSign(term), f.three(vif)]),
  );
  for (const [name, matrix] of [
    ["Variance proportions", result.collinearity.variance_proportions],
    ["Correlation of the columns", result.collinearity.correlation],
  ])
    assert.deepEqual(
      await rowsOf(name),
      matrix.map((/** @type {number[]} */ row, /** @type {number} */ i) => [
        termSign(result.coefficients[i].term),
        ...row.map((value) => f.fixed(value, 2)),
      ]),
    );
  const text = (await page.locator("main").textContent()) ?? "";
  for (const value of [
    f.three(result.residuals.sigma),
    f.three(result.residuals.max_abs),
    f.fixed(result.residuals.r_squared, 4),
    f.fixed(result.numerics.correct_digits, 1),
    result.provenance.input_sha256,
    result.warnings[0].message,
  ])
    assert.ok(text.includes(value), value);

  // the first direction, by the keyboard
  const chart = page.getByRole("slider", { name: "Eigenvalues" });
  await chart.focus();
  await chart.press("Enter");
  const [worst] = result.collinearity.near_dependencies;
  await page.locator(".direction").getByText(termSign(worst.sentence)).waitFor();
  assert.deepEqual(
    await rowsOf("Weights of the direction"),
    worst.weights.map((/** @type {number} */ weight, /** @type {number} */ i) => [
      termSign(result.coefficients[i].term),
      f.fixed(weight, 3),
    ]),
  );
  await page.reload();
  await loaded();
  await page.locator(".direction").getByText(termSign(worst.sentence)).waitFor();

  const figure = page.locator("figure").filter({ has: page.getByRole("heading", { name: "Histogram" }) });
  await figure.getByRole("button", { name: "As table" }).click();
  const counts = (await rowsOf("Histogram")).map((row) => Number(row[2]));
  assert.equal(
    counts.reduce((a, b) => a + b, 0),
    result.residuals.values.length,
  );

  await page.getByRole("button", { name: "Replay" }).click();
  await page.getByText("identical bit for bit").waitFor();
});

browserTest("a robust fit shows its weights and what it rejects", {}, async ({ page, open, job, iteration, call }) => {
  const { id } = await job();
  const { fits } = await iteration(id);
  const kept = await call("POST", `/v1/jobs/${id}/iterations/1/fits`, {
    ...fits[0].spec,
    estimator: { type: "m_estimator", loss: "tukey", tuning: [2], scale: { rule: "mad" } },
    include: ["robust_weights", "residuals"],
  });
  const { robust } = kept.result;
  await open(`/jobs/${id}/iterations/1/statistics?fit=${kept.id}`);
  await page.getByText(`Nodes with zero weight: ${robust.rejected_count}.`).waitFor();
  await page.getByRole("slider", { name: "Robust weights" }).waitFor();
  const rows = page.getByRole("table", { name: "Rejected nodes" }).locator("tbody tr");
  assert.equal(await rows.count(), robust.rejected.length);
  assert.ok(robust.rejected.length > 0);
});
