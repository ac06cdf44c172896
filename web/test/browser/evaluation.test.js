// Evaluated traces as tester sheets.

import assert from "node:assert/strict";
import { browserTest, example } from "./harness.js";
import { agrees } from "./numbers.js";

const posted = async () => JSON.parse(await example("requests/gear_evaluate.json"));
/** @param {string} id */
const pathOf = (id) => `/jobs/${id}/iterations/1/evaluation`;

browserTest("the figures of a sheet are the interface's, and a class brings band and tolerances", {}, async (world) => {
  const { page, open, loaded, job, iteration, call } = world;
  const { id } = await job();
  await iteration(id);
  await open(pathOf(id));
  await page.getByText("Evaluated profiles, helices and pitches appear here").waitFor();
  const record = await call("POST", `/v1/jobs/${id}/iterations/1/evaluations`, await posted());
  await page.reload();
  await page.getByRole("heading", { name: "Profiles" }).waitFor();
  await loaded();
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
      agrees(await cells.nth(3).textContent(), trace.form_um);
      agrees(await cells.nth(4).textContent(), trace.total_um);
      agrees(await cells.nth(5).textContent(), trace.crowning_um);
    }
    const mean = record.result.means.find((/** @type {any} */ one) => one.kind === kind);
    agrees(await rows.nth(traces.length).locator("td .cell").nth(1).textContent(), mean.slope_um.mean);
  }
  await page.getByText("material increases towards the tip").first().waitFor();
  await page.getByText("deviates to the left hand").waitFor();

  await page.getByLabel("Class of the K-band").selectOption("3");
  await page.locator(".k-band").first().waitFor();
  const { gear } = await posted();
  const tolerances = await call("POST", "/v1/gears/tolerances", { gear, class: 3 });
  const row = page.getByRole("table", { name: "Profiles" }).locator("tbody tr", { hasText: "Tolerance, class 3" });
  agrees(await row.locator("td .cell").nth(1).textContent(), tolerances.rounded.profile_slope_um);
  agrees(await row.locator("td .cell").nth(4).textContent(), tolerances.rounded.profile_total_um);
  await page.locator(".k-outside-line").first().waitFor();
  await page.reload();
  await page.locator(".k-band").first().waitFor();
});

browserTest("other ranges and a class to conform to make another evaluation", { statuses: [422] }, async (world) => {
  const { page, open, loaded, job, iteration, call } = world;
  const { id } = await job();
  await iteration(id);
  await call("POST", `/v1/jobs/${id}/iterations/1/evaluations`, await posted());
  await open(pathOf(id));
  await page.getByText("Evaluate with different ranges, sign or class").click();
  await page.getByLabel("Helix range from").fill("20");
  await page.getByRole("button", { name: "Evaluate", exact: true }).click();
  await page.locator("form .field-error, form .failure").first().waitFor();
  assert.equal(await page.getByLabel("Helix range from").inputValue(), "20");
  await page.getByLabel("Helix range from").fill("1,5");
  await page.getByLabel("Required class").selectOption("6");
  await page.getByRole("button", { name: "Evaluate", exact: true }).click();
  await page
    .locator(".badge", { hasText: /conforms|conform|undecided/ })
    .first()
    .waitFor();
  await loaded();
  const { items } = await call("GET", `/v1/jobs/${id}/iterations/1/records`);
  assert.equal(items.length, 2);
  const last = await call("GET", `/v1/jobs/${id}/iterations/1/records/${items[1].id}`);
  assert.deepEqual(last.request.evaluation.helix_range_mm, [1.5, 14.25]);
  const outcome = last.result.traces[0].slope_conformity.verdict;
  const words = { conforms: "conforms", does_not_conform: "does not conform", undecidable: "undecidable" };
  const cell = page.getByRole("table", { name: "Profiles" }).locator("tbody tr").first().locator(".badge");
  assert.equal((await cell.textContent())?.trim(), words[/** @type {"conforms"} */ (outcome)]);
  assert.equal(new URL(page.url()).searchParams.get("record"), items[1].id);
});

browserTest("traces are read against the design of the job", {}, async (world) => {
  const { page, open, loaded, job, iteration, call } = world;
  const requirements = { design: { profile_crowning_um: 4, helix_crowning_um: 5 }, tolerance_limits: { class: 7 } };
  const { id } = await job({ requirements });
  await iteration(id);
  await call("POST", `/v1/jobs/${id}/iterations/1/evaluations`, await posted());
  await open(pathOf(id));
  await page.getByText("the involute").first().waitFor();
  await page.getByText("Evaluate with different ranges, sign or class").click();
  await page.getByLabel("Deviations from").selectOption("design");
  await page.getByRole("button", { name: "Evaluate", exact: true }).click();
  await page.locator("dd", { hasText: "the design" }).waitFor();
  await loaded();
  const { items } = await call("GET", `/v1/jobs/${id}/iterations/1/records`);
  const [first, last] = await Promise.all(
    items.map((/** @type {{ id: string }} */ one) => call("GET", `/v1/jobs/${id}/iterations/1/records/${one.id}`)),
  );
  assert.equal(last.result.evaluation.against, "design");
  const cells = page.getByRole("table", { name: "Profiles" }).locator("tbody tr").first().locator("td .cell");
  agrees(await cells.nth(5).textContent(), last.result.traces[0].crowning_um);
  const less = first.result.traces[0].crowning_um - last.result.traces[0].crowning_um;
  assert.ok(Math.abs(less - 4) < 1e-6, String(less));
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

browserTest("traces are compared with the limits and bands of the job", {}, async (world) => {
  const { page, open, loaded, job, iteration, call } = world;
  const { requirements } = JSON.parse(await example("requests/job_requirements.json"));
  // from end to end of the example's traces, one wide enough for them and one too narrow
  const band = (/** @type {number} */ wide) => ({
    kind: "profile",
    profile_axis: "diameter",
    upper: [50.3, 54.02].map((at) => [at, wide]),
    lower: [50.3, 54.02].map((at) => [at, -wide]),
  });
  requirements.k_bands = [band(8), band(1)];
  const { id } = await job({ requirements });
  await iteration(id);
  const { result } = await call("POST", `/v1/jobs/${id}/iterations/1/evaluations`, await posted());
  await open(pathOf(id));
  const traces = result.traces.filter((/** @type {any} */ one) => one.kind === "profile");
  const rows = page.getByRole("table", { name: "Profiles" }).locator("tbody tr");
  const within = (/** @type {boolean} */ is) => (is ? "within the limits" : "outside the limits");
  const words = { conforms: "conforms", does_not_conform: "does not conform", undecidable: "undecidable" };
  for (const [i, trace] of traces.entries()) {
    const cells = await rows.nth(i).locator("td .cell").allTextContents();
    agrees(cells[1], trace.slope_um, trace.slope_std_error_um, ...trace.slope_interval_um);
    for (const [cell, name] of /** @type {const} */ ([
      [1, "slope"],
      [3, "form"],
      [4, "total"],
      [5, "crowning"],
    ])) {
      const verdict = trace[`${name}_conformity`]?.verdict;
      const said = verdict ? words[/** @type {"conforms"} */ (verdict)] : within(trace[`${name}_within`]);
      assert.ok(cells[cell]?.includes(said), `${name}: ${cells[cell]}`);
    }
    const [wide, narrow] = trace.k_bands;
    assert.equal(narrow.within, false);
    const said = cells.at(-1)?.split("Band 1: ")[1];
    if (wide.within === undefined) assert.match(said ?? "", /^undecidable/);
    else agrees(said, wide.clearance_um);
    agrees(cells.at(-1)?.split("Band 2: ")[1], -narrow.clearance_um);
  }
  assert.ok(
    traces.some((/** @type {any} */ { k_bands: [wide] }) => wide.within),
    "one of them lies in the wide band",
  );
  const limits = page.getByRole("table", { name: "Profiles" }).getByRole("row", { name: "Limits" });
  await limits.getByText("1 … 6", { exact: true }).waitFor();

  // two bands a chart; mean line and parabola lie at the places of the result
  const chart = page.getByRole("img", { name: /^Profiles, Tooth 1/ });
  assert.equal(await chart.locator(".k-band.required").count(), 2);
  assert.ok((await chart.locator(".k-outside-line").count()) > 0, "what is outside of the narrow band is marked");
  const ends = await chart.evaluate((svg) => {
    const points = (/** @type {string} */ path) =>
      [...(svg.querySelector(path)?.getAttribute("d") ?? "").matchAll(/(-?[\d.]+) (-?[\d.]+)/g)].map(([, x, y]) => [
        Number(x),
        Number(y),
      ]);
    const ticks = [...svg.querySelectorAll("text[text-anchor=middle]:not(.k-scale text)")].map((text) => [
      Number(text.getAttribute("x")),
      Number(text.textContent?.replace("−", "-")),
    ]);
    return { mean: points(".k-mean"), parabola: points(".k-parabola"), ticks };
  });
  const [[x0 = 0, value0 = 0] = [], [x1 = 0, value1 = 0] = []] = [ends.ticks[0], ends.ticks.at(-1)];
  const drawn = (/** @type {number | undefined} */ x) => value0 + ((x ?? 0) - x0) * ((value1 - value0) / (x1 - x0));
  const near = (/** @type {number | undefined} */ x, /** @type {number} */ value) =>
    assert.ok(Math.abs(drawn(x) - value) < 0.02, `drawn at ${drawn(x)}, answered ${value}`);
  near(ends.mean[0]?.[0], traces[0].mean_line_um[0]);
  near(ends.mean[1]?.[0], traces[0].mean_line_um[1]);
  near(ends.parabola[12]?.[0], traces[0].mean_parabola_um[1]);

  await page.getByLabel("Class of the K-band").selectOption("6");
  await chart.locator(".k-band:not(.required)").waitFor();
  await page.getByLabel("Class of the K-band").selectOption({ label: "as required" });
  await chart.locator(".k-band.required").first().waitFor();
  await loaded();
});

browserTest("pitches and run-out are held against their limits, one by one", {}, async (world) => {
  const { page, open, job, iteration, call } = world;
  const { id } = await job({
    requirements: {
      tolerance_limits: { class: 6 },
      pitch_limits: { left: { single_pitch_um: [-1, 1] }, cumulative_pitch_um: [0, 9.5], runout_um: [0, 8] },
    },
  });
  await iteration(id);
  const sent = JSON.parse(await example("requests/iteration_pitch.json"));
  const { result } = await call("POST", `/v1/jobs/${id}/iterations/1/pitch`, {
    ...sent,
    standard_uncertainty_um: { single_pitch: 0.05, cumulative_pitch: 0.5 },
  });
  const { left, runout } = result;
  assert.deepEqual([left.single_pitch_within, left.cumulative_pitch_within, runout.within], [false, true, true]);
  await open(pathOf(id));
  const rows = page.getByRole("table", { name: "Pitch and run-out" }).locator("tbody tr");
  const words = { conforms: "conforms", does_not_conform: "does not conform", undecidable: "undecidable" };
  for (const [at, within, limits, conformity] of /** @type {const} */ ([
    [0, left.single_pitch_within, left.single_pitch_limits_um, left.single_pitch_conformity],
    [1, left.cumulative_pitch_within, left.cumulative_pitch_limits_um, left.cumulative_pitch_conformity],
    [7, runout.within, runout.limits_um, runout.conformity],
  ])) {
    const cells = await rows.nth(at).locator("td .cell").allTextContents();
    assert.ok(cells[1]?.endsWith(within ? "within the limits" : "outside the limits"), cells[1]);
    assert.equal(cells[5], limits.join(" … ").replaceAll("-", "−"));
    assert.equal(cells[6]?.trim(), conformity ? words[/** @type {"conforms"} */ (conformity.verdict)] : "–");
  }
  assert.deepEqual(
    [left.single_pitch_conformity.verdict, left.cumulative_pitch_conformity.verdict, runout.conformity],
    ["does_not_conform", "undecidable", undefined],
  );
  // figures without limits have no mark
  assert.equal(await rows.nth(2).locator(".within").count(), 0);
  const single = page.getByRole("figure", { name: "Single pitch deviations, left flanks" });
  assert.equal(await single.locator(".mark-rule.limit").count(), 2, "the limits are drawn");
  // a result keeps the requirements that applied to it
  await call("PATCH", `/v1/jobs/${id}`, { requirements: { pitch_limits: { runout_um: [0, 1] } } });
  await open(pathOf(id));
  await rows.nth(7).getByText("within the limits").waitFor();
  await rows.nth(7).getByText("0 … 8", { exact: true }).waitFor();
});

browserTest("pitches and run-out are drawn, and every figure is the interface's", {}, async (world) => {
  const { page, open, job, iteration, call } = world;
  const { id } = await job({ requirements: { tolerance_limits: { class: 5 } } });
  await iteration(id);
  const sent = JSON.parse(await example("requests/iteration_pitch.json"));
  // both flanks, one of them with a tooth that was not measured
  const right = { single_pitch_um: sent.left.single_pitch_um.map((/** @type {number} */ one) => -2 * one) };
  const { result } = await call("POST", `/v1/jobs/${id}/iterations/1/pitch`, { ...sent, right });
  await open(pathOf(id));
  const { gear } = await call("GET", `/v1/jobs/${id}`);
  const { rounded } = await call("POST", "/v1/gears/tolerances", { gear, class: 5 });
  const rows = page.getByRole("table", { name: "Pitch and run-out" }).locator("tbody tr");
  let at = 0;
  for (const flank of [result.left, result.right]) {
    for (const [value, tooth, tolerance, of] of [
      [flank.single_pitch.value_um, flank.single_pitch.tooth, rounded.single_pitch_um, flank.class.single_pitch],
      [flank.cumulative_pitch_um, undefined, rounded.cumulative_pitch_um, flank.class.cumulative_pitch],
      [flank.sector_pitch_2013.value_um, flank.sector_pitch_2013.tooth],
      [flank.sector_sum_2013.value_um, flank.sector_sum_2013.tooth],
      [flank.sector_pitch_1995.value_um, flank.sector_pitch_1995.tooth],
      [flank.single_pitch_range_um],
      [flank.adjacent_pitch_difference.value_um, flank.adjacent_pitch_difference.tooth],
    ]) {
      const cells = await rows.nth(at).locator("td .cell").allTextContents();
      agrees(cells[1], value);
      if (tooth !== undefined) agrees(cells[2], tooth);
      if (tolerance !== undefined) agrees(cells[3], tolerance);
      if (of !== undefined) agrees(cells[4], of);
      at += 1;
    }
  }
  agrees(await rows.nth(at).locator("td .cell").nth(1).textContent(), result.runout.runout_um);
  // the required class limits them: one flank is within, the other has a tooth too far
  assert.deepEqual([result.left.single_pitch_within, result.left.cumulative_pitch_within], [true, true]);
  await rows.nth(0).getByText("within the limits").waitFor();
  const { amount_um, std_error_um, angle_deg } = result.runout.eccentricity;
  const runout = page.getByRole("region", { name: "Run-out", exact: true });
  agrees(await runout.locator("dd").nth(0).textContent(), amount_um, std_error_um);
  agrees(await runout.locator("dd").nth(1).textContent(), angle_deg);

  // a bar a tooth, above 0 where the pitch is too long; the same as a table
  const left = page.getByRole("region", { name: "left flanks" });
  const bars = await left
    .locator(".mark-bars.series-blue rect")
    .evaluateAll((all) => all.map((one) => [Number(one.getAttribute("y")), Number(one.getAttribute("height"))]));
  const singles = result.left.single_pitch_deviation_um;
  assert.equal(bars.length, singles.length);
  const [tallest = 0] = bars.map(([, height = 0]) => height).sort((a, b) => b - a);
  const zero = Math.max(...bars.filter((_, i) => singles[i] > 0).map(([y = 0, height = 0]) => y + height));
  const greatest = Math.max(...singles.map(Math.abs));
  for (const [i, [y = 0, height = 0]] of bars.entries()) {
    assert.ok(Math.abs(height / tallest - Math.abs(singles[i]) / greatest) < 1e-6, `bar ${i + 1}`);
    assert.ok(Math.abs(singles[i] > 0 ? y + height - zero : y - zero) < 1e-6, `bar ${i + 1} begins at 0`);
  }
  await left.getByRole("button", { name: "As table" }).nth(1).click();
  const cells = left.getByRole("table").locator("tbody td .cell");
  for (const [i, value] of result.left.index_deviation_um.entries()) agrees(await cells.nth(i).textContent(), value);
});
