// The page of a flank map: its numbers, layers and marks are the interface's own.

import assert from "node:assert/strict";
import { axisOf, drawnIn, near } from "./drawn.js";
import { browserTest, example } from "./harness.js";
import { unitOf } from "./numbers.js";
import { formats } from "../../app/lib/format.js";
import { termSign } from "../../app/lib/terms.js";

const f = formats("en");

/** @param {readonly (number | null)[]} heights */
function withoutMean(heights) {
  const there = heights.flatMap((one) => one ?? []);
  const mean = there.reduce((sum, one) => sum + one, 0) / there.length;
  return heights.map((one) => (one === null ? null : one - mean));
}

browserTest("the fit is next to the map: facts, coefficients, errors, intervals and bounds", {}, async (world) => {
  const { page, open, job, iteration, call } = world;
  const { id } = await job();
  const { fits } = await iteration(id);
  const at = `/v1/jobs/${id}/iterations/1`;
  const kept = await call("POST", `${at}/fits`, { ...fits[0].spec, level: 0.9 });
  await call("PUT", `${at}/chosen-fit`, { fit_id: kept.id });
  const { result } = await call("GET", `${at}/fits/${kept.id}`);
  const { residuals, regularization, spectrum } = result;
  await open(`/jobs/${id}/iterations/1`);
  const facts = (/** @type {string} */ name) =>
    page
      .getByRole("region", { name, exact: true })
      .locator("dl > div")
      .evaluateAll((all) => all.map((one) => [...one.children].map((part) => part.textContent)));
  assert.deepEqual(await facts("Figures of the chosen fit"), [
    ["RMS of the residuals", `${f.three(residuals.rms)} µm`],
    ["Greatest residual", `${f.three(residuals.max_abs)} µm`],
    ["Standard deviation σ̂", `${f.three(residuals.sigma)} µm`],
    ["λ*", f.three(regularization.lambda_star)],
    ["Chosen by", regularization.criterion],
    ["Condition", f.condition(spectrum.condition)],
    ["Condition, regularised", f.condition(spectrum.regularized.condition)],
  ]);
  const expected = await call("GET", at);
  const measured = Object.fromEntries(await facts("Measurement"));
  assert.deepEqual([measured["Nodes"], measured["Tooth"]], [String(expected.node_count), expected.tooth]);

  const region = page.getByRole("region", { name: "Coefficients", exact: true });
  await region.getByRole("columnheader", { name: "90 % interval" }).waitFor();
  const rows = await region.locator("tbody tr").evaluateAll((all) =>
    all.map((row) => ({
      term: row.querySelector(".term")?.textContent,
      cells: [...row.querySelectorAll("td .cell")].map((one) => one.textContent?.trim()),
      drawn: row.querySelector("svg.strip")?.getAttribute("aria-label") ?? "",
    })),
  );
  assert.equal(rows.length, result.coefficients.length);
  for (const [i, one] of result.coefficients.entries()) {
    const { term, cells, drawn } = rows[i] ?? { cells: [], drawn: "" };
    const unit = unitOf(one);
    assert.equal(term, termSign(one.term));
    assert.deepEqual(cells, [
      f.withError(one.value, one.std_error, unit),
      `${f.significant(one.bias_bound, 2)}\u202f${unit}`,
      `${f.interval(one.interval, one.least_squares_std_error)}\u202f${unit}`,
    ]);
    // the drawing agrees
    for (const said of cells) assert.ok(said && drawn.includes(said.split("\u202f")[0] ?? said), `${said} in ${drawn}`);
  }
});

browserTest("a correction has its layers: prediction and response", {}, async (world) => {
  const { page, open, loaded, job, iteration, call } = world;
  const { id } = await job();
  await iteration(id);
  const at = `/v1/jobs/${id}/iterations/1`;
  await call("POST", `${at}/correction`, JSON.parse(await example("requests/iteration_correction.json")));
  await iteration(id, "flank_z52_remachined.json");
  const { result, answer } = await call("GET", `${at}/correction?include=nodes`);
  const { u, v } = await call("GET", `${at}/nodes`);
  const [row, column] = [3, 7];
  await open(`/jobs/${id}/iterations/1?layer=predicted&at=${u[row]},${v[column]}`);
  /** @param {readonly (number | null)[]} expected @param {string} name */
  const shows = async (expected, name) => {
    // by a machine, without a datum: minus their mean
    const heights = withoutMean(expected);
    const there = heights.filter((one) => one !== null);
    for (const [key, most] of /** @type {const} */ ([
      ["least", Math.min(...there)],
      ["greatest", Math.max(...there)],
    ])) {
      const index = heights.indexOf(most);
      const place = `row ${Math.floor(index / v.length) + 1}, column ${(index % v.length) + 1}`;
      const said = await page.locator(`[data-extreme="${key}"]`).textContent();
      assert.ok(said?.includes(`· ${f.um(most)} µm · ${place}`), `${name}, ${key} ${most} at ${place}: ${said}`);
    }
    const read = await page.getByRole("slider", { name: `Iteration 1: ${name}` }).getAttribute("aria-valuetext");
    const height = heights[row * v.length + column] ?? Number.NaN;
    assert.ok(read?.includes(`· ${f.um(height)} µm · row ${row + 1}, column ${column + 1}`), `${name}: ${read}`);
  };
  await shows(result.predicted.deviation_um, "Predicted by the correction");
  await page.getByLabel("Layer").selectOption({ label: "Measured after the correction" });
  await page.getByText(`Measured by iteration ${answer.iteration}.`).waitFor();
  await loaded();
  await shows(answer.measured_um, "Measured after the correction");

  // the same place on axes of mm and of per cent of the range
  const [low, high] = [v[0], v.at(-1)];
  const share = (100 * (v[column] - low)) / (high - low);
  const heat = page.locator(".heat-map").first();
  const cross = () => heat.locator(".map-crosshair circle").getAttribute("cx").then(Number);
  near(await cross(), axisOf((await drawnIn(heat)).x, "linear")(v[column]), "mm");
  await page.getByRole("button", { name: "As % of the range" }).click();
  await heat.getByText("Face width / %").waitFor();
  near(await cross(), axisOf((await drawnIn(heat)).x, "linear")(share), "per cent");

  // a manual scale, outside which heights are counted
  const beyond = withoutMean(answer.measured_um).filter((z) => z !== null && Math.abs(z) > 2);
  await page.getByLabel("Scale limit").selectOption({ label: "±2" });
  await page.waitForURL(/limit=2/);
  await page.getByText(`${beyond.length} heights outside the scale`).waitFor();
  const ends = await page.locator(".map-legend text").allTextContents();
  assert.deepEqual([ends[0], ends.at(-1)], ["−2", "2"]);
});

browserTest("maps of a job share one scale, labelled in full, and a tab keeps what is seen", {}, async (world) => {
  const { page, open, loaded, job, iteration } = world;
  const { id } = await job();
  await iteration(id);
  await iteration(id, "flank_z52_remachined.json");
  const ends = async () => {
    const labels = await page.locator(".map-legend text").allTextContents();
    return labels.map((label) => Number(label.replace("\u2212", "-")));
  };
  await open(`/jobs/${id}/iterations/1`);
  const first = await ends();
  const limit = first.at(-1) ?? Number.NaN;
  assert.deepEqual(first, [-limit, -limit / 2, 0, limit / 2, limit]);
  assert.equal(await page.getByText(/outside the scale/).count(), 0, "nothing is clipped");
  await open(`/jobs/${id}/iterations/2`);
  assert.deepEqual(await ends(), first, "the second has smaller deviations, and the same scale");
  await page.getByLabel("Layer").selectOption({ label: "Residual" });
  await loaded();
  assert.ok(((await ends()).at(-1) ?? limit) < limit / 2, "residuals have their own");

  await page.getByLabel("Layer").selectOption({ label: "Fitted" });
  await page.getByRole("button", { name: "Contours" }).click();
  await page.getByLabel("Scale limit").selectOption({ label: "±5" });
  await page.waitForURL(/limit=5/);
  assert.deepEqual(await ends(), [-5, -2.5, 0, 2.5, 5]);
  const seen = new URL(page.url()).search;
  await page.getByRole("link", { name: "Iteration 1", exact: true }).click();
  await page.waitForURL("**/iterations/1?**");
  await loaded();
  assert.equal(new URL(page.url()).search, seen);
  assert.equal(await page.getByRole("button", { name: "Contours" }).getAttribute("aria-pressed"), "true");
  assert.deepEqual(await ends(), [-5, -2.5, 0, 2.5, 5]);
});

for (const theme of ["light", "dark"]) {
  browserTest(
    `marks of a map are of the colour of text, as in its legend, ${theme}`,
    { settings: { theme } },
    async (world) => {
      const { page, open, job, iteration } = world;
      const { id } = await job();
      await iteration(id);
      await open(`/jobs/${id}/iterations/1`);
      const { ink, surface, marks, legend, frame } = await page.evaluate(() => {
        const style = (/** @type {Element | null} */ one) => getComputedStyle(/** @type {Element} */ (one));
        const all = (/** @type {string} */ found) => [...document.querySelectorAll(found)].map(style);
        return {
          ink: style(document.body).color,
          surface: style(document.querySelector(".map-panel")).backgroundColor,
          marks: all(".heat-map .map-extreme > *").map(({ fill }) => fill),
          legend: all(".map-extremes .filled").map(({ fill }) => fill),
          frame: all(".heat-map .map-range:not(.halo)").map(({ stroke }) => stroke),
        };
      });
      assert.deepEqual(marks, [surface, ink, surface, ink], "each on a ground of its own, whatever is below");
      assert.deepEqual(legend, [ink, ink]);
      assert.deepEqual(frame, [ink]);
    },
  );
}
