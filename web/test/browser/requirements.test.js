// The requirements of a job, and figures compared with them.

import assert from "node:assert/strict";
import { browserTest, example } from "./harness.js";
import { agrees } from "./numbers.js";

const exampleRequirements = async () => JSON.parse(await example("requests/job_requirements.json")).requirements;
const NAMES = /** @type {const} */ (["profile_slope", "helix_slope", "profile_crowning", "helix_crowning", "twist"]);

browserTest("requirements are shown, edited, and refused where they cannot be", { statuses: [422] }, async (world) => {
  const { page, open, job, call } = world;
  const { id } = await job();
  await open(`/jobs/${id}`);
  const panel = page.getByRole("region", { name: "Requirements" });
  await panel.getByText("This job has no requirements").waitFor();
  await page.getByRole("button", { name: "Edit" }).click();
  const dialog = page.getByRole("dialog");
  const names = await dialog.locator(".limits-row > .limits-name").evaluateAll((all) =>
    all.map((one) => {
      const { display, lineHeight } = getComputedStyle(one);
      return { display, lineHeight: Number.parseFloat(lineHeight) };
    }),
  );
  assert.ok(names.length >= NAMES.length, `${names.length} names`);
  for (const { display, lineHeight } of names) {
    assert.equal(display, "grid", "names below each other");
    assert.ok(lineHeight >= 16, `lines of ${lineHeight} px`);
  }
  await dialog.getByLabel("Accuracy class").selectOption("6");
  await dialog.getByLabel("Twist, Both flanks, from").fill("-4,5");
  await page.getByRole("button", { name: "Save" }).click();
  await dialog.getByText("Enter both ends or none.").waitFor();
  await dialog.getByLabel("Twist, Both flanks, to").fill("4");
  await dialog.getByText("Limits of one flank").click();
  await dialog.getByLabel("Helix slope, Left flank, from").fill("-6");
  await dialog.getByLabel("Helix slope, Left flank, to").fill("2");
  await dialog.getByRole("button", { name: "Add a K-band" }).click();
  await dialog.getByLabel("Upper line").fill("0 2\n15 2");
  await dialog.getByLabel("Lower line").fill("0 -10\n7,5 3\n15 -10");
  await page.getByRole("button", { name: "Save" }).click();
  // a lower line above the upper one: the server names the place
  await dialog.locator(".field-error [lang=en]").first().waitFor();
  await dialog.getByLabel("Lower line").fill("0 -10\n7,5 -3\n15 -10");
  await page.getByRole("button", { name: "Save" }).click();
  await page.getByText("The job has been changed.").waitFor();
  const { requirements } = await call("GET", `/v1/jobs/${id}`);
  assert.deepEqual(requirements.tolerance_limits, { class: 6, twist_um: [-4.5, 4], left: { helix_slope_um: [-6, 2] } });
  assert.deepEqual(requirements.k_bands[0].lower, [
    [0, -10],
    [7.5, -3],
    [15, -10],
  ]);
  await panel.getByText("Class 6 of ISO 1328-1:2013").waitFor();
  await panel.getByText("−4.5 … 4", { exact: true }).waitFor();
  await panel.getByRole("button", { name: "As table" }).click();
  await panel.getByRole("cell", { name: "−3", exact: true }).waitFor();
});

browserTest(
  "limits of pitches and run-out are edited, shown, and refused at their fields",
  { statuses: [422] },
  async (world) => {
    const { page, open, job, call } = world;
    const { id } = await job({ requirements: await exampleRequirements() });
    await open(`/jobs/${id}`);
    const panel = page.getByRole("region", { name: "Requirements" });
    await panel.getByRole("row", { name: /Run-out.*0 … 18/ }).waitFor();
    await page.getByRole("button", { name: "Edit" }).click();
    const dialog = page.getByRole("dialog");
    const to = (/** @type {string} */ figure) => dialog.getByLabel(`${figure}, to`, { exact: true });
    assert.equal(await to("Run-out").inputValue(), "18");
    assert.equal(
      await to("Single pitch, Left flank").inputValue(),
      "6",
      "limits of one flank are open where there are some",
    );
    await dialog.getByLabel("Pitch class").selectOption("5");
    await to("Run-out").fill("");
    await page.getByRole("button", { name: "Save" }).click();
    await dialog.getByText("Enter both ends or none.").waitFor();
    await to("Run-out").fill("15");
    await dialog.getByLabel("Total cumulative pitch, Both flanks, from", { exact: true }).fill("20");
    await to("Total cumulative pitch, Both flanks").fill("20");
    await page.getByRole("button", { name: "Save" }).click();
    // equal ends: the server reports them at the figure
    const row = dialog.getByRole("group", { name: "Total cumulative pitch" }).first();
    await row.locator(".field-error [lang=en]").waitFor();
    await dialog.getByLabel("Total cumulative pitch, Both flanks, from", { exact: true }).fill("0");
    await to("Total cumulative pitch, Both flanks").fill("20");
    await page.getByRole("button", { name: "Save" }).click();
    await page.getByText("The job has been changed.").waitFor();
    const { requirements } = await call("GET", `/v1/jobs/${id}`);
    assert.deepEqual(requirements, {
      ...(await exampleRequirements()),
      pitch_limits: { class: 5, cumulative_pitch_um: [0, 20], runout_um: [0, 15], left: { single_pitch_um: [-6, 6] } },
    });
    await panel.getByText("Pitches and run-out: class 5 of ISO 1328-1:2013").waitFor();
    await panel.getByRole("row", { name: /Total cumulative pitch.*0 … 20/ }).waitFor();
  },
);

browserTest("a new job brings its requirements", { alone: true }, async ({ page, open, call }) => {
  await open("/jobs/new");
  await page.getByLabel("Name").fill("with limits");
  await page.getByLabel("With gear data").uncheck();
  await page.getByText("Enter them now").click();
  await page.getByLabel("Profile crowning, Both flanks, from").fill("1");
  await page.getByLabel("Profile crowning, Both flanks, to").fill("6");
  await page.getByRole("button", { name: "Create the job" }).click();
  await page.getByRole("heading", { name: "with limits" }).waitFor();
  const { items } = await call("GET", "/v1/jobs");
  const stored = await call("GET", `/v1/jobs/${items[0].id}`);
  assert.deepEqual(stored.requirements, { tolerance_limits: { profile_crowning_um: [1, 6] } });
});

browserTest(
  "figures of fits are the interface's on every page, against their limits",
  { alone: true },
  async (world) => {
    const { page, open, job, iteration, call } = world;
    const { id } = await job({ requirements: await exampleRequirements() });
    await iteration(id);
    await iteration(id, "flank_z52_remachined.json");
    const { iterations } = await call("GET", `/v1/jobs/${id}/trace`);
    const all = iterations.map((/** @type {any} */ one) => one.fits[0].figures);
    assert.equal(all[0].profile_slope_um.within, false, "the first iteration is outside a limit");

    await open(`/jobs/${id}`);
    const words = { conforms: "conforms", does_not_conform: "does not conform", undecidable: "undecidable" };
    const rows = page.getByRole("region", { name: "Slopes, crownings, twist", exact: true }).locator("tbody tr");
    for (const [i, figures] of all.entries())
      for (const [k, name] of NAMES.entries()) {
        const text = await rows.nth(i).locator("td .cell").nth(k).textContent();
        const { value, std_error, conformity } = figures[`${name}_um`];
        agrees(text, value, std_error);
        assert.ok(text?.includes(words[/** @type {"conforms"} */ (conformity.verdict)]), text ?? "");
      }
    for (const [k, name] of NAMES.entries()) {
      const limits = all[1][`${name}_um`].conformity.limits_um.join(" … ").replaceAll("-", "−");
      assert.equal(await rows.nth(2).locator("td .cell").nth(k).textContent(), limits);
    }
    // slopes are extended to the full face width and have the full limits; a fit keeps the limits valid when it was made
    assert.deepEqual(all[1].helix_slope_um.conformity.limits_um, [-6, 2]);
    const changed = await exampleRequirements();
    changed.tolerance_limits.left.helix_slope_um = [-5, 2];
    await call("PATCH", `/v1/jobs/${id}`, { requirements: changed });
    await rows.nth(2).getByText("Applied limits").waitFor();
    await rows.nth(3).getByText("Required limits").waitFor();
    assert.deepEqual(await rows.nth(3).locator("td .cell").allTextContents(), ["–", "−5 … 2", "–", "–", "–"]);
    await page.getByText("A fit keeps the limits of the job at the time it was computed.").waitFor();

    await open(`/jobs/${id}/iterations/1`);
    const own = page.getByRole("region", { name: "Slopes, crownings, twist", exact: true }).locator("tbody tr");
    for (const [k, name] of NAMES.entries()) {
      const { value, std_error, interval, bias_bound, conformity } = all[0][`${name}_um`];
      const cells = await own.nth(k).locator("td .cell").allTextContents();
      agrees(cells[0], value, std_error);
      agrees(cells[1], interval[0], interval[1]);
      agrees(cells[2], bias_bound);
      const limits = conformity.limits_um.join(" … ").replaceAll("-", "−");
      assert.equal(cells[3]?.trim(), limits + words[/** @type {"conforms"} */ (conformity.verdict)]);
    }

    await open(`/jobs/${id}/trace`);
    const expected = page.locator(".figures-short").first().locator("dd");
    for (const [k, name] of NAMES.entries()) {
      const { value, std_error } = all[0][`${name}_um`];
      agrees(await expected.nth(k).textContent(), value, std_error);
    }

    await open("/jobs");
    const { items } = await call("GET", "/v1/jobs");
    const flank = page.getByRole("img", { name: /^Left flank with its figures/ });
    const said = (await flank.getAttribute("aria-label")) ?? "";
    for (const [k, name] of NAMES.entries())
      agrees(said.split(", ")[k]?.split(" ").at(-1), items[0].figures[`${name}_um`]);
    const painted = await flank.evaluate((canvas) => {
      const { width, height } = /** @type {HTMLCanvasElement} */ (canvas);
      const { data } = /** @type {CanvasRenderingContext2D} */ (
        /** @type {HTMLCanvasElement} */ (canvas).getContext("2d")
      ).getImageData(0, 0, width, height);
      return {
        colours: new Set(Array.from({ length: width * height }, (_, i) => data.slice(4 * i, 4 * i + 3).join())).size,
        alpha: data[3],
      };
    });
    assert.ok(painted.colours > 20 && painted.alpha === 255, JSON.stringify(painted));
  },
);

browserTest(
  "the same nodes are the same small flank, left or right",
  { alone: true },
  async ({ page, open, job, call }) => {
    const nodes = JSON.parse(await example("flank_z52.json"));
    // a helix slope, so that a flank drawn from the wrong face is another picture
    const tilted = nodes.nodes.z.map((/** @type {(number | null)[]} */ row) =>
      row.map((z, j) => z && z + 0.5 * nodes.nodes.v[j]),
    );
    nodes.nodes = { ...nodes.nodes, z: tilted };
    for (const flank of ["left", "right"]) {
      const { id } = await job({ name: flank });
      await call("POST", `/v1/jobs/${id}/iterations`, { ...nodes, flank });
    }
    const { items } = await call("GET", "/v1/jobs?sort=name");
    const slopes = items.map((/** @type {any} */ one) => one.figures.helix_slope_um);
    assert.ok(Math.abs(slopes[0]) > 1 && Math.abs(slopes[0] + slopes[1]) < 1e-9, `${slopes}`);
    await open("/jobs");
    const pictures = [];
    for (const name of [/^Left flank/, /^Right flank/])
      pictures.push(
        await page
          .getByRole("img", { name })
          .evaluate((canvas) => /** @type {HTMLCanvasElement} */ (canvas).toDataURL("image/png")),
      );
    assert.equal(pictures[0], pictures[1]);
    assert.deepEqual(await page.locator(".flank-side").allTextContents(), ["right", "left"]);
  },
);

browserTest("a figure at its limit has no tick in the list", { alone: true }, async ({ page, open, job, call }) => {
  const scatter = "TDZQUOUEIUZJWJHUTXDHISRNWOUCCNQGMMAGYIOJXWTHO";
  const u = Array.from({ length: 9 }, (_, i) => 5.2 + 0.8 * i);
  const v = Array.from({ length: 5 }, (_, j) => 0.5 + 3.5 * j);
  const iteration = {
    nodes: {
      type: "grid",
      u,
      v,
      z: u.map((_, i) => v.map((_, j) => scatter.charCodeAt(5 * i + j) / 25 - 3.1)),
    },
    flank: "right",
    axes: {
      u: { quantity: "roll_length", unit: "mm" },
      v: { quantity: "face_width", unit: "mm" },
      z: { quantity: "deviation", unit: "um" },
    },
    model: { type: "polynomial", degree: 2, terms: "total" },
    regularization: { type: "none" },
  };
  const measured = async (/** @type {number} */ limit) => {
    const { id } = await job({ requirements: { tolerance_limits: { profile_slope_um: [-90, limit] } } });
    return (await call("POST", `/v1/jobs/${id}/iterations`, iteration)).fits[0].figures.profile_slope_um;
  };
  const { value } = await measured(90);
  await open("/jobs");
  await page.locator(".flank-cell .within.good").waitFor();
  const { within, conformity } = await measured(value + 1e-3);
  assert.deepEqual([within, conformity.verdict], [true, "undecidable"]);
  await open("/jobs");
  await page.locator(".flank-cell .within.warn", { hasText: "undecidable" }).waitFor();
  assert.equal(await page.locator(".flank-cell .within.good").count(), 1);
});

browserTest(
  "a verdict whose assumptions are doubtful has no tick",
  { alone: true },
  async ({ page, open, job, call }) => {
    const { id } = await job({ requirements: { tolerance_limits: { profile_slope_um: [-20, 20] } } });
    // a relief that a surface of second order cannot follow
    const u = Array.from({ length: 11 }, (_, i) => 5.2 + 0.66 * i);
    const v = Array.from({ length: 9 }, (_, j) => 0.5 + 1.75 * j);
    const z = u.map((_, i) => v.map((_, j) => 0.4 * Math.sin(13 * i + 78 * j) - 10 * Math.max(0, (i - 7) / 3) ** 2));
    const axes = {
      u: { quantity: "roll_length", unit: "mm" },
      v: { quantity: "face_width", unit: "mm" },
      z: { quantity: "deviation", unit: "um" },
    };
    const model = { type: "polynomial", degree: 2, terms: "total" };
    const { fits } = await call("POST", `/v1/jobs/${id}/iterations`, {
      nodes: { type: "grid", u, v, z },
      flank: "right",
      axes,
      model,
      regularization: { type: "none" },
    });
    const { conformity } = fits[0].figures.profile_slope_um;
    assert.deepEqual([conformity.verdict, conformity.assumptions], ["conforms", "doubtful"]);
    await open(`/jobs/${id}/iterations/1`);
    const tile = page.locator(".figure-tile").first();
    assert.match((await tile.textContent()) ?? "", /!conforms, doubtful: .*lack of fit of the model/);
    const panel = page.getByRole("region", { name: "Slopes, crownings, twist", exact: true });
    await panel.locator(".badge.warn", { hasText: "doubtful" }).waitFor();
    await panel.getByText(/^Doubtful: .*lack of fit of the model/).waitFor();
    for (const path of [`/jobs/${id}`, `/jobs/${id}/iterations/1`, "/jobs", `/jobs/${id}/report`]) {
      await open(path);
      await page.getByText("!", { exact: true }).first().waitFor();
      assert.equal(await page.locator(".within", { hasText: "✓" }).count(), 0, path);
    }
  },
);
