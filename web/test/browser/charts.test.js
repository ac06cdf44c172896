// Charts of λ* and of the spectrum: marks are at the places of the interface's numbers.

import assert from "node:assert/strict";
import { axisOf, drawnIn, heightAt, near } from "./drawn.js";
import { browserTest } from "./harness.js";
import { formats } from "../../app/lib/format.js";

const f = formats("en");

/** @typedef {import("playwright-core").Page} Page */

/** @param {Page} page @param {string} name */
const figureOf = (page, name) =>
  page.locator("figure").filter({ has: page.getByRole("heading", { name, exact: true }) });

browserTest("the curves, the plateau and the chosen fit are at their places", {}, async (world) => {
  const { page, open, job, iteration, call } = world;
  const { id } = await job();
  const { fits } = await iteration(id);
  const at = `/v1/jobs/${id}/iterations/1/fits`;
  const [{ spec }] = fits;
  const regularization = { ...spec.regularization, lambda_star: { criterion: "min_condition" } };
  const flat = await call("POST", at, { ...spec, regularization, include: ["lambda_curve"] });
  const chosen = fits[0].result.regularization.lambda_star;
  await open(`/jobs/${id}/iterations/1/lambda?fit=${flat.id}`);
  const { lambda_curve: curve, regularization: result } = flat.result;
  assert.equal(result.lambda_star_interval.length, 2);
  for (const [of, name, kind] of /** @type {const} */ ([
    ["predicted_mse", "Predicted MSE", "log"],
    ["condition", "Condition", "log"],
    ["rms", "RMS", "linear"],
    ["gcv", "GCV function", "log"],
    ["bias_norm", "Bias norm", "log"],
  ])) {
    const drawn = await drawnIn(figureOf(page, name));
    const [x, y] = [axisOf(drawn.x, "log"), axisOf(drawn.y, kind)];
    assert.equal(drawn.lines.length, 1, name);
    const [line = []] = drawn.lines;
    // a log axis has no place for 0, which is drawn at its foot
    const points = curve.filter((/** @type {any} */ point) => kind === "linear" || point[of] > 0);
    const first = line.length - points.length;
    assert.ok(first >= 0, name);
    for (const [i, point] of points.entries()) {
      near(line[first + i]?.x, x(point.lambda_star), `${name}, point ${i}`);
      near(line[first + i]?.y, y(point[of]), `${name}, point ${i}`);
    }
    for (const [i, end] of result.lambda_star_interval.entries()) near(drawn.span?.[i], x(end), `${name}, plateau`);
    const [mark, ...more] = drawn.dots["vermilion"] ?? [];
    assert.equal(more.length, 0, name);
    near(mark?.x, x(chosen), `${name}, the chosen fit`);
    near(mark?.y, heightAt(line, x(chosen)), `${name}, the chosen fit`);
    const choices = result.choices.flatMap((/** @type {any} */ { lambda_star: value }) =>
      value === undefined ? [] : [x(value)],
    );
    for (const value of choices)
      assert.ok(
        drawn.rules.some((rule) => Math.abs((rule.x ?? Number.NaN) - value) < 1.01),
        `${name}: a choice at ${value} of ${JSON.stringify(drawn.rules)}`,
      );
  }
});

browserTest("the ridge trace has each coefficient, and marks k", {}, async (world) => {
  const { page, open, job, iteration, call } = world;
  const { id } = await job();
  const { fits } = await iteration(id);
  const at = `/v1/jobs/${id}/iterations/1/fits`;
  const body = { ...fits[0].spec, regularization: { type: "ridge" }, include: ["ridge_trace"] };
  const { id: ridge, result } = await call("POST", at, body);
  await open(`/jobs/${id}/iterations/1/lambda?fit=${ridge}`);
  const figure = figureOf(page, "Ridge trace");
  const drawn = await drawnIn(figure);
  const [x, y] = [axisOf(drawn.x, "log"), axisOf(drawn.y, "linear")];
  const along = result.ridge_trace.filter((/** @type {any} */ { k }) => k > 0);
  assert.equal(drawn.lines.length, result.coefficients.length);
  for (const [i, line] of drawn.lines.entries()) {
    const { term, least_squares } = result.coefficients[i];
    assert.equal(line.length, along.length, term);
    for (const [j, { k, coefficients }] of along.entries()) {
      near(line[j]?.x, x(k), `${term}, point ${j}`);
      near(line[j]?.y, y(coefficients[i] / least_squares), `${term}, point ${j}`);
    }
  }
  assert.equal(drawn.rules.length, 1);
  near(drawn.rules[0]?.x, x(result.regularization.lambda_star), "the fit's own k");
  await figure.getByRole("button", { name: "As table" }).click();
  const rows = await figure
    .locator("tbody tr")
    .evaluateAll((all) => all.map((row) => [...row.querySelectorAll(".cell")].map((one) => one.textContent)));
  assert.deepEqual(
    rows,
    result.ridge_trace.map((/** @type {any} */ { k, coefficients }) => [k, ...coefficients].map(f.three)),
  );
});

browserTest("the spectrum has all eigenvalues, λₙ over the limit of the condition, and L", {}, async (world) => {
  const { page, open, job, iteration } = world;
  const { id } = await job();
  const { fits } = await iteration(id);
  const { spec, result } = fits[0];
  await open(`/jobs/${id}/iterations/1/statistics`);
  const drawn = await drawnIn(figureOf(page, "Eigenvalues"));
  const [x, y] = [axisOf(drawn.x, "linear"), axisOf(drawn.y, "log")];
  const { eigenvalues, regularized } = result.spectrum;
  for (const [series, values] of /** @type {const} */ ([
    ["blue", eigenvalues],
    ["vermilion", regularized.eigenvalues],
  ])) {
    assert.equal(drawn.dots[series]?.length, values.length, series);
    for (const [i, value] of values.entries()) {
      near(drawn.dots[series]?.[i]?.x, x(i + 1), `${series} ${i + 1}`);
      near(drawn.dots[series]?.[i]?.y, y(value), `${series} ${i + 1}`);
    }
  }
  assert.equal(drawn.rules.length, 2);
  near(drawn.rules[0]?.y, y(eigenvalues.at(-1) / spec.regularization.condition_limit), "λₙ/condition_limit");
  // behind the last direction that is regularised, before the first that is not
  const raised = eigenvalues.filter(
    (/** @type {number} */ value, /** @type {number} */ i) => value < 0.995 * regularized.eigenvalues[i],
  );
  assert.equal(raised.length, 1);
  near(drawn.rules[1]?.x, x(1.5), "raised");
  await page.getByText("1 raised", { exact: true }).waitFor();
  await page.getByText("1 of 9 eigenvalues raised.").waitFor();
});
