// The pages of the report behind the first: K-charts' figures, λ*, spectra, correction and trace are the interface's own.

import assert from "node:assert/strict";
import { axisOf, drawnIn, heightAt, near } from "./drawn.js";
import { browserTest } from "./harness.js";
import { agrees } from "./numbers.js";
import { story } from "./paper.js";
import { formats } from "../../app/lib/format.js";

const f = formats("en");

/** @typedef {import("playwright-core").Page} Page */

/** @param {Page} page @param {string} name @returns {Promise<string[][]>} */
const rowsOf = (page, name) =>
  page
    .locator(".report")
    .getByRole("table", { name, exact: true })
    .locator("tbody tr")
    .evaluateAll((all) =>
      all.map((row) =>
        [...row.children].map((cell) => ((cell.querySelector(".cell") ?? cell).textContent ?? "").trim()),
      ),
    );

/** @param {any[]} all @param {string} kind */
const last = (all, kind) => all.findLast((one) => one.kind === kind).id;

browserTest("the figures behind the first page are the interface's, part by part", {}, async (world) => {
  const { page, open, call } = world;
  const id = await story(world);
  const at = `/v1/jobs/${id}/iterations`;
  await open(`/jobs/${id}/report`);

  // K-charts: traces of each tooth flank, left before right, then means and spreads
  const { items } = await call("GET", `${at}/1/records`);
  const { result } = await call("GET", `${at}/1/records/${last(items, "evaluation")}`);
  for (const [kind, name] of /** @type {const} */ ([
    ["profile", "Profiles, Iteration 1"],
    ["helix", "Helices, Iteration 1"],
  ])) {
    const rows = await rowsOf(page, name);
    const of = (/** @type {any[]} */ all) =>
      ["left", "right"].flatMap((flank) => all.filter((one) => one.kind === kind && one.flank === flank));
    const traces = of(result.traces);
    assert.ok(traces.length > 0);
    for (const [i, trace] of traces.entries()) {
      const [tooth, , slope, form, total, crowning] = rows[i] ?? [];
      assert.equal(tooth, `Tooth ${trace.tooth}`);
      // errors are given if noise was
      agrees(slope, ...[trace.slope_um, trace.slope_std_error_um].slice(0, trace.slope_std_error_um ? 2 : 1));
      agrees(form, trace.form_um);
      agrees(total, trace.total_um);
      agrees(crowning, trace.crowning_um);
    }
    const means = of(result.means).flatMap((mean) =>
      ["mean", "variation"].map((what) => ["slope", "form", "total"].map((key) => mean[`${key}_um`][what])),
    );
    for (const [i, values] of means.entries())
      for (const [k, value] of values.entries()) agrees(rows[traces.length + i]?.[2 + k], value);
  }

  // λ* and the spectrum of either iteration
  for (const number of [1, 2]) {
    const { fits } = await call("GET", `${at}/${number}`);
    const chosen = fits.find((/** @type {any} */ one) => one.chosen);
    const fit = await call("GET", `${at}/${number}/fits/${chosen.id}?include=lambda_curve`);
    const { regularization, spectrum, lambda_curve: curve } = fit.result;
    const choices = await rowsOf(page, `Choice of λ*, Iteration ${number}`);
    assert.deepEqual(
      choices.map((row) => row.slice(1, 6)),
      regularization.choices.map((/** @type {any} */ one) => [
        f.three(one.lambda_star),
        f.three(one.predicted_mse),
        f.condition(one.condition),
        f.three(one.rms),
        f.three(one.bias_norm),
      ]),
    );
    const marked = choices.filter((row) => row.at(-1) !== "").map(([criterion]) => criterion?.split(" ").at(-1));
    assert.deepEqual(marked, [regularization.criterion]);
    const drawn = await drawnIn(page.locator(".report .lambda figure").nth(number - 1));
    const [x, y] = [axisOf(drawn.x, "log"), axisOf(drawn.y, "log")];
    for (const [i, point] of curve.entries()) {
      near(drawn.lines[0]?.[i]?.x, x(point.lambda_star), `λ* of ${number}, point ${i}`);
      near(drawn.lines[0]?.[i]?.y, y(point.predicted_mse), `λ* of ${number}, point ${i}`);
    }
    const mark = drawn.dots["vermilion"]?.[0];
    near(mark?.x, x(regularization.lambda_star), "the chosen fit");
    // between its points the curve is drawn straight
    assert.ok(Math.abs((mark?.y ?? 0) - heightAt(drawn.lines[0] ?? [], mark?.x ?? 0)) < 3, JSON.stringify(mark));
    const spectra = await drawnIn(page.locator(".report .spectrum figure").nth(number - 1));
    const up = axisOf(spectra.y, "log");
    for (const [series, values] of /** @type {const} */ ([
      ["blue", spectrum.eigenvalues],
      ["vermilion", spectrum.regularized.eigenvalues],
    ]))
      for (const [i, value] of values.entries()) near(spectra.dots[series]?.[i]?.y, up(value), `${series} ${i + 1}`);
  }

  // the correction
  const kept = await call("GET", `${at}/1/correction`);
  const changes = await rowsOf(page, "Changes of the machine settings, Iteration 1");
  assert.equal(changes.length, kept.result.settings.length);
  for (const [i, setting] of kept.result.settings.entries()) {
    const [name, change, error, bound] = changes[i] ?? [];
    assert.ok(name?.includes(setting.name), name);
    if (setting.fixed || setting.undetermined) continue;
    agrees(change, setting.change);
    agrees(error, setting.std_error);
    agrees(bound, setting.bias_bound);
  }
  const figures = await rowsOf(page, "Figures before, predicted and measured, Iteration 1");
  const keys = ["profile_slope", "helix_slope", "profile_crowning", "helix_crowning", "twist"];
  for (const [i, key] of keys.entries()) {
    const expected = kept.answer.figure_changes[`${key}_um`];
    const [, before, , predicted, measured, change] = figures[i] ?? [];
    agrees(before, expected.before.value_um, expected.before.std_error_um);
    agrees(predicted, expected.predicted_um);
    agrees(measured, expected.measured.value_um, expected.measured.std_error_um);
    agrees(change, expected.change.value_um, expected.change.std_error_um);
  }

  // the trace: all that happened, with criteria, λ*, decisions and reasons
  const { iterations } = await call("GET", `/v1/jobs/${id}/trace`);
  const entries = await rowsOf(page, "Trace");
  const count = (/** @type {any} */ one) =>
    1 + one.fits.length + one.choices.length + one.records.length + one.decisions.length;
  assert.equal(
    entries.length,
    iterations.reduce((/** @type {number} */ sum, /** @type {any} */ one) => sum + count(one), 0),
  );
  for (const one of iterations) {
    const own = entries.filter((row) => row[1] === String(one.number));
    assert.equal(own.length, count(one));
    for (const fit of one.fits) {
      const said = `${fit.criterion} λ* ${f.three(fit.lambda_star)}`;
      const there = own.find(([, , event, what]) => event === "fit" && what?.endsWith(said));
      assert.ok(there, `${said} in ${JSON.stringify(own)}`);
      assert.equal(there.at(-1), fit.reason ?? "");
    }
    for (const { decision, reason } of one.decisions) {
      const words = { remachine: "machine again", accepted: "accepted" }[String(decision)];
      assert.ok(
        own.some((row) => row[2] === "decision" && row[3] === words && row[4] === reason),
        `${reason}`,
      );
    }
    for (const { method } of one.records) assert.ok(own.some((row) => row[2] === "record" && row[3]?.endsWith(method)));
  }
});
