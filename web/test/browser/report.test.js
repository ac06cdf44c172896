// The report: its contents on paper, and that the first page is one page.

import assert from "node:assert/strict";
import { formats } from "../../app/lib/format.js";
import { browserTest, example } from "./harness.js";
import { holds, onPaper, printed, run, story } from "./paper.js";

/** @typedef {import("./harness.js").World} World */

browserTest("the first page is complete, with the figures of the interface and the decision", {}, async (world) => {
  const { page, open, call } = world;
  const id = await story(world);
  await open(`/jobs/${id}/report`);
  const { file, pages } = await printed(world);
  const f = formats("en");
  const first = pages[0] ?? "";
  const at = `/v1/jobs/${id}/iterations`;
  const { answer } = await call("GET", `${at}/1/correction`);
  const [before, after] = [await call("GET", `${at}/1`), await call("GET", `${at}/2`)];
  const chosen = [before, after].map(({ fits }) => fits.find((/** @type {any} */ one) => one.chosen));
  holds(first, ["Flank report", "Pump gear, finish grinding", "97340", "form grinder 3", "Page 1/"]);
  holds(first, ["machine again", "beyond class 5", "accepted", "within the drawing", "Signature"]);
  for (const { before: b, measured, change } of /** @type {any[]} */ (Object.values(answer.figure_changes))) {
    holds(
      first,
      [b, measured, change].map((one) => f.withError(one.value_um, one.std_error_um)),
    );
  }
  for (const fit of chosen) holds(first, [f.three(fit.rms), f.three(fit.lambda_star), fit.criterion]);
  // absent values have a reason
  holds(first, ["No limits, or no uncertainty", "iteration 2 has none"]);
  assert.ok(!first.includes("Flank maps"), "the rest begins on the next page");
  assert.match(pages[1] ?? "", /Flank maps/);
  assert.ok(!(pages[1] ?? "").includes("Signature"), "nothing of the first page runs over");
  const { stdout } = await run("pdfinfo", [file]);
  assert.match(stdout, /Page size: +59\d\.?\d* x 84\d\.?\d* pts \(A4\)/);
  assert.equal(Number(/Pages: +(\d+)/.exec(stdout)?.[1]), pages.length);
  // with a column of changes, which a report with figures from traces lacks
  for (const lang of ["de", "en"]) {
    await open(`/jobs/${id}/report?lang=${lang}`);
    await onPaper(world, lang);
  }
  for (const [i, text] of pages.entries()) holds(text, ["Pump gear, finish grinding", `Page ${i + 1}/${pages.length}`]);

  // the rest
  const rest = pages.slice(1).join(" ");
  const whole = await call("GET", `${at}/2/fits/${chosen[1].id}`);
  const digest = whole.result.provenance.input_sha256;
  holds(rest, ["the error budget asks for it", "Eigenvalues", "Trace", "Warnings", digest]);
  holds(rest, [
    whole.result.provenance.engine,
    ...whole.result.regularization.choices.map((/** @type {any} */ c) => c.criterion),
  ]);
  // no control is printed
  const printable = await page.locator("button, a, select, input").evaluateAll((all) => all.length);
  assert.ok(printable > 0);
  await page.emulateMedia({ media: "print" });
  const seen = await page
    .locator("button, select, input, nav, header.top")
    .evaluateAll((all) => all.filter((one) => one.checkVisibility()).map((one) => one.outerHTML));
  assert.deepEqual(seen, []);
});

browserTest("maps are drawn at 300 dots an inch, and no figure is split", {}, async (world) => {
  const { page, open } = world;
  const id = await story(world);
  await open(`/jobs/${id}/report?parts=maps,evaluation,spectrum,correction`);
  const densities = await page
    .locator(".report canvas")
    .evaluateAll((all) => all.map((one) => /** @type {HTMLCanvasElement} */ (one).width / one.clientWidth));
  assert.ok(densities.length >= 7, `${densities.length} maps`);
  for (const density of densities) assert.ok(Math.abs(density - 300 / 96) < 0.02, `${density}`);
  await page.emulateMedia({ media: "print" });
  const split = await page
    .locator(".report :is(figure, .chart-figure)")
    .evaluateAll((all) => all.filter((one) => getComputedStyle(one).breakInside !== "avoid").length);
  assert.equal(split, 0);
  const { pages } = await printed(world);
  assert.ok(!pages.join(" ").includes("Signature"), "the first page was not selected");
});

browserTest(
  "the bar chooses iterations and parts, and the address keeps them",
  {},
  async ({ page, open, loaded, ...world }) => {
    const id = await story({ page, open, loaded, ...world });
    await world.iteration(id);
    await open(`/jobs/${id}`);
    await page.getByRole("navigation", { name: "Views" }).getByRole("link", { name: "Report" }).click();
    await page.getByRole("heading", { name: "Flank maps" }).waitFor();
    await loaded();
    assert.equal(await page.getByLabel("Iteration 2", { exact: true }).isChecked(), false, "the first and the last");
    await page.getByLabel("Iteration 2", { exact: true }).check();
    await page.getByLabel("Iteration 3", { exact: true }).uncheck();
    await page.waitForURL("**/report?iterations=1%2C2");
    await page.getByRole("heading", { name: "Measured deviations, Iteration 2" }).waitFor();
    for (const part of ["Flank maps", "Correction", "Trace", "First page"])
      await page.getByRole("checkbox", { name: part }).uncheck();
    await page.reload();
    await loaded();
    assert.equal(await page.getByRole("heading", { name: "Flank maps" }).count(), 0);
    assert.equal(await page.getByRole("checkbox", { name: "Trace" }).isChecked(), false);
    await page.getByRole("heading", { name: "Eigenvalues" }).waitFor();
    await page.evaluate(() => {
      globalThis.print = () => document.body.setAttribute("data-printed", "yes");
    });
    await page.getByRole("button", { name: "Print" }).click();
    assert.equal(await page.locator("body").getAttribute("data-printed"), "yes");
    await page.getByLabel("Language of the report").selectOption("de");
    await page.getByRole("heading", { name: "Eigenwerte" }).waitFor();
    await page.getByRole("link", { name: "Übersicht" }).click();
    await page.getByText("Decide on iteration 3").waitFor();
    assert.equal(await page.locator("html").getAttribute("lang"), "en", "the dashboard keeps its own");
  },
);

browserTest(
  "in German, with its comma, whatever the dashboard speaks",
  { settings: { theme: "dark" } },
  async (world) => {
    const { open, call, page } = world;
    const id = await story(world);
    await open(`/jobs/${id}/report?iterations=1,2&lang=de`);
    await page.getByText("Flankenbericht").waitFor();
    assert.equal(await page.locator(".report").evaluate((one) => getComputedStyle(one).colorScheme), "light");
    const { pages } = await printed(world);
    const { answer } = await call("GET", `/v1/jobs/${id}/iterations/1/correction`);
    const slope = answer.figure_changes.profile_slope_um.before;
    holds(pages[0] ?? "", [
      "Flankenbericht",
      "Unterschrift",
      "nacharbeiten",
      formats("de").withError(slope.value_um, slope.std_error_um),
      `Seite 1/${pages.length}`,
    ]);
    assert.match(pages[1] ?? "", /Flankenkarten/);
  },
);

const EVIL = "<img src=x onerror=alert(1)>";

browserTest("names are text in print too, and long ones leave the first page one page", {}, async (world) => {
  const { open, page } = world;
  page.on("dialog", () => assert.fail("a script has run"));
  const id = await story(world, { name: EVIL, machine: "m".repeat(120), serial_number: '"; } * { display: none } \\' });
  await open(`/jobs/${id}/report`);
  const { pages } = await printed(world);
  for (const text of pages) holds(text, [EVIL]);
  assert.equal(await page.locator(".report img").count(), 0);
  holds(pages[0] ?? "", ["Signature", '"; } * { display: none }']);

  const long = await world.job({ name: "Long ".repeat(38).trim() });
  await world.iteration(long.id);
  await world.call("PATCH", `/v1/jobs/${long.id}/iterations/1`, {
    decision: "rejected",
    reason: "because ".repeat(400),
  });
  await open(`/jobs/${long.id}/report?parts=summary`);
  const alone = await printed(world);
  assert.equal(alone.pages.length, 1);
  const { fits } = await world.call("GET", `/v1/jobs/${long.id}/iterations/1`);
  const slope = fits[0].figures.profile_slope_um;
  // without a correction and without traces it has the fit's own figures
  holds(alone.pages[0] ?? "", [
    "rejected",
    "Signature",
    "Page 1/1",
    formats("en").withError(slope.value, slope.std_error),
  ]);
});

browserTest("limits of an evaluation are next to its figures, with their marks", {}, async (world) => {
  const { open, call, page } = world;
  const { id } = await world.job();
  await world.iteration(id);
  const request = JSON.parse(await example("requests/gear_evaluate.json"));
  request.evaluation.tolerance_limits = { class: 5, profile_crowning_um: [1, 6] };
  const record = await call("POST", `/v1/jobs/${id}/iterations/1/evaluations`, request);
  await open(`/jobs/${id}/report`);
  const f = formats("en");
  const { pages } = await printed(world);
  const surface = record.result.surfaces[0];
  for (const name of ["profile_slope_um", "helix_slope_um", "profile_crowning_um", "helix_crowning_um"]) {
    const { value, std_error } = surface[name];
    holds(pages[0] ?? "", [f.withError(value, std_error)]);
  }
  holds(pages[0] ?? "", ["from the surface through the evaluated traces", "1.0 … 6.0", "−4.5 … 4.5 ✗"]);
  assert.equal(record.result.traces[0].slope_conformity.verdict, "does_not_conform");
  await page.getByText("K-band: F α").waitFor();
});

browserTest("all that the first page can hold is still one page, with its signature", {}, async (world) => {
  const { open, call } = world;
  const { id } = await world.job({ name: "Sun gear of the second stage, order 118, ground after hardening, lot 7" });
  const request = JSON.parse(await example("requests/gear_evaluate.json"));
  const kinds = ["profile", "helix"].map((kind) => request.traces.find((/** @type {any} */ one) => one.kind === kind));
  request.traces = ["left", "right"].flatMap((flank) =>
    ["1", "14", "27", "40"].flatMap((tooth) => kinds.map((trace) => ({ ...trace, tooth, flank }))),
  );
  request.evaluation.tolerance_limits = { class: 5, twist_um: [-3, 3] };
  const at = `/v1/jobs/${id}/iterations`;
  for (const file of ["flank_z52.json", "flank_z52_remachined.json"]) await world.iteration(id, file);
  for (const number of [1, 2]) {
    await call("POST", `${at}/${number}/evaluations`, request);
    await call("PATCH", `${at}/${number}`, { decision: "remachine", reason: "because ".repeat(60) });
  }
  await call("POST", `${at}/1/correction`, JSON.parse(await example("requests/iteration_correction.json")));
  for (const [lang, signed] of /** @type {const} */ ([
    ["en", "Signature"],
    ["de", "Unterschrift"],
  ])) {
    await open(`/jobs/${id}/report?lang=${lang}`);
    const { pages } = await printed(world);
    holds(pages[0] ?? "", [signed]);
    assert.ok(!(pages[1] ?? "").includes(signed));
    await onPaper(world, lang);
  }
});

browserTest("nodes that are no flank have a report without maps", {}, async (world) => {
  const { id } = await world.job();
  await world.call("POST", `/v1/jobs/${id}/iterations`, await example("requests/fit_curve.json"));
  await world.open(`/jobs/${id}/report`);
  const { pages } = await printed(world);
  holds(pages.join(" "), ["The nodes do not form a flank", "do not form a surface", "Eigenvalues"]);
  assert.ok(!(pages[1] ?? "").includes("Signature"));
});

/** Limits of pitches that one flank keeps and the other does not; the run-out's own. */
const PITCH_LIMITS = { class: 6, left: { single_pitch_um: [-1, 1] }, runout_um: [0, 8] };

/** @param {World} world */
async function pitches({ job, iteration, call }) {
  const { id } = await job({ requirements: { pitch_limits: PITCH_LIMITS } });
  await iteration(id);
  const sent = JSON.parse(await example("requests/iteration_pitch.json"));
  const right = { single_pitch_um: sent.left.single_pitch_um.map((/** @type {number} */ one) => -2 * one) };
  const { result } = await call("POST", `/v1/jobs/${id}/iterations/1/pitch`, {
    ...sent,
    right,
    standard_uncertainty_um: { single_pitch: 0.05 },
  });
  await iteration(id, "flank_z52_remachined.json");
  return { id, result };
}

for (const [lang, words] of /** @type {const} */ ([
  [
    "en",
    {
      title: "Pitch and run-out",
      single: "Single pitch",
      outside: "does not conform",
      note: "Teeth are counted clockwise.",
      warnings: "Warnings",
    },
  ],
  [
    "de",
    {
      title: "Teilung und Rundlauf",
      single: "Teilungs-Einzelabweichung",
      outside: "nicht konform",
      note: "Zähne sind im Uhrzeigersinn gezählt.",
      warnings: "Warnungen",
    },
  ],
]))
  browserTest(`pitches and run-out are a part of their own, with limits and decisions (${lang})`, {}, async (world) => {
    const { page, open } = world;
    const { id, result } = await pitches(world);
    await open(`/jobs/${id}/report?parts=pitch,warnings&lang=${lang}`);
    const f = formats(lang);
    const { pages } = await printed(world);
    // the charts fill a page, the tables follow
    const first = pages.join(" ");
    holds(first, [words.title, words.single, words.outside]);
    // the space around the dots depends on the font
    const tight = first.replaceAll(" … ", "…");
    const limits = (/** @type {readonly number[]} */ ends) =>
      holds(tight, [ends.map((end) => f.input(end).replace("-", "−")).join("…")]);
    for (const flank of [result.left, result.right]) {
      holds(first, [
        `${f.um(flank.single_pitch.value_um)} ${flank.single_pitch_within ? "✓" : "✗"}`,
        `${f.um(flank.cumulative_pitch_um)} ${flank.cumulative_pitch_within ? "✓" : "✗"}`,
      ]);
      limits(flank.single_pitch_limits_um);
      limits(flank.cumulative_pitch_limits_um);
    }
    assert.deepEqual([result.left.single_pitch_within, result.runout.within], [false, true]);
    holds(first, [`${f.um(result.runout.runout_um)} ✓`, words.note]);
    limits(result.runout.limits_um);
    // the second iteration, which has none, only shows its warnings
    const [own = ""] = first.split(words.warnings);
    assert.ok(!own.includes("Iteration 2"), own);
    // all of an iteration on one page, with nothing to press
    const charts = page.locator(".report .pitch-flank figure");
    assert.equal(await charts.count(), 5);
    assert.equal(await page.locator(".report [role=slider]").count(), 0);
    assert.equal(await page.locator(".report .mark-rule.limit").count(), 4, "the limits are drawn");
    holds(first, [f.withError(result.runout.eccentricity.amount_um, result.runout.eccentricity.std_error_um)]);
  });

browserTest("a report of iterations without pitches says so", {}, async (world) => {
  const { page, open } = world;
  const { id } = await pitches(world);
  await open(`/jobs/${id}/report?iterations=2&parts=pitch`);
  await page.getByText("No pitches have been evaluated for these iterations.").waitFor();
});

browserTest("an iteration shows its pitches in short, and links to them", {}, async (world) => {
  const { page, open } = world;
  const { id, result } = await pitches(world);
  await open(`/jobs/${id}/iterations/1`);
  const short = page.getByRole("region", { name: "Pitch and run-out" });
  await short.locator("dl").waitFor();
  const f = formats("en");
  const said = (/** @type {boolean} */ within) => (within ? "✓within the limits" : "✗outside the limits");
  const lines = await short
    .locator("dd")
    .evaluateAll((all) => all.map((one) => (one.textContent ?? "").replaceAll(/\s+/gu, " ").trim()));
  const figure = (/** @type {string} */ name, /** @type {number} */ value, /** @type {boolean} */ within) =>
    `${name} ${f.um(value)} µm ${said(within)}`;
  assert.deepEqual(lines, [
    ...[result.left, result.right].map((flank) =>
      [
        figure("fp Single pitch", flank.single_pitch.value_um, flank.single_pitch_within),
        figure("Fp Total cumulative pitch", flank.cumulative_pitch_um, flank.cumulative_pitch_within),
      ].join(" "),
    ),
    figure("Fr Run-out", result.runout.runout_um, result.runout.within),
  ]);
  await short.getByRole("link", { name: "Evaluation" }).click();
  await page.waitForURL("**/iterations/1/evaluation");
  await page.getByRole("table", { name: "Pitch and run-out" }).waitFor();
  await open(`/jobs/${id}/iterations/2`);
  await page.getByRole("heading", { name: "Measurement" }).waitFor();
  assert.equal(await short.count(), 0, "an iteration without pitches says nothing of them");
});

browserTest("axe finds nothing in a German report with all its parts", {}, async (world) => {
  const id = await story(world);
  const at = `/v1/jobs/${id}/iterations/2`;
  await world.call("POST", `${at}/evaluations`, await example("requests/gear_evaluate.json"));
  await world.call("POST", `${at}/pitch`, JSON.parse(await example("requests/iteration_pitch.json")));
  await world.call("POST", `${at}/correction`, JSON.parse(await example("requests/iteration_correction.json")));
  await world.open(`/jobs/${id}/report?lang=de`);
  await world.accessible();
});

browserTest("a job without a measurement has nothing to report yet", {}, async ({ page, open, job }) => {
  const { id } = await job();
  await open(`/jobs/${id}/report`);
  await page.getByText("The report appears here").waitFor();
  await page.getByRole("link", { name: "Measure" }).first().waitFor();
});

browserTest(
  "other pages print without what is pressed, light, and whole tables",
  { settings: { theme: "dark" } },
  async (world) => {
    const { page, open } = world;
    const id = await story(world);
    for (const place of [`/jobs/${id}`, `/jobs/${id}/trace`, `/jobs/${id}/iterations/1/lambda`]) {
      await open(place);
      await page.emulateMedia({ media: "print" });
      const seen = await page
        .locator("button, nav, header.top, .job-navigation, .table-tools > :not(.table-note)")
        .evaluateAll((all) => all.filter((one) => one.checkVisibility()).map((one) => one.outerHTML));
      assert.deepEqual(seen, [], place);
      assert.equal(await page.locator("html").evaluate((one) => getComputedStyle(one).colorScheme), "light");
      assert.equal(
        await page
          .locator(".table-scroll")
          .first()
          .evaluate((one) => getComputedStyle(one).overflowX),
        "visible",
      );
      await page.emulateMedia({ media: "screen" });
    }
  },
);
