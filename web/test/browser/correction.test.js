// Corrections: requested, refused, and compared with the next iteration.

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { browserTest, example } from "./harness.js";

const request = async () => JSON.parse(await example("requests/iteration_correction.json"));
/** @param {string} id */
const pathOf = (id) => `/jobs/${id}/iterations/1/correction`;

/** Checks a number as it is shown: it has to be the interface's to its last digit. @param {string | null | undefined} text @param {number} value */
function agrees(text, value) {
  const written = /[−+]?\d+(\.\d+)?/.exec(text ?? "")?.[0];
  assert.ok(written, `no number in ${text}`);
  const decimals = written.split(".")[1]?.length ?? 0;
  assert.equal(
    Number(written.replace("−", "-")).toFixed(decimals),
    (value + 0).toFixed(decimals).replace(/^-(0\.?0*)$/, "$1"),
    text ?? "",
  );
}

browserTest("a correction is requested, entered, and compared with the next measurement", {}, async (world) => {
  const { page, open, loaded, job, iteration, call } = world;
  const { id } = await job();
  await iteration(id);
  await call("PATCH", `/v1/jobs/${id}/iterations/1`, { decision: "remachine" });
  await open(pathOf(id));
  await page.getByText("appear here once they have been computed").waitFor();
  const angle = page.getByRole("group", { name: "Profile angle" });
  await angle.getByLabel("Minimum").fill("−20");
  await angle.getByLabel("Maximum").fill("20");
  await angle.getByLabel("Step").fill("0,05");
  await page.getByRole("group", { name: "Infeed" }).getByLabel("Fixed").check();
  await page.getByLabel("Noise of a deviation").fill("0.5");
  await page.getByLabel("Uncertainty of the response").fill("0.02");
  await page.getByRole("button", { name: "Compute the correction" }).click();
  await page.getByRole("heading", { name: "Changes of the machine settings" }).waitFor();
  await loaded();
  const kept = await call("GET", `/v1/jobs/${id}/iterations/1/correction`);
  const body = await request();
  assert.deepEqual(kept.request.limits, body.limits);
  const rows = page.getByRole("table", { name: "Changes of the machine settings" }).locator("tbody tr");
  assert.equal(await rows.count(), kept.result.settings.length);
  for (const [i, setting] of kept.result.settings.entries()) {
    const cells = rows.nth(i).locator("th .cell, td .cell");
    assert.ok((await cells.nth(0).textContent())?.includes(setting.name));
    if (setting.fixed || setting.undetermined) continue;
    agrees(await cells.nth(1).textContent(), setting.change);
    agrees(await cells.nth(2).textContent(), setting.std_error);
  }
  await page.getByText("not determined by this measurement").first().waitFor();
  await page.getByText("This flank and tooth have not been measured since").waitFor();

  await iteration(id, "flank_z52_remachined.json");
  await page.reload();
  await page.getByText("different from predicted").waitFor();
  await loaded();
  const { answer, result } = await call("GET", `/v1/jobs/${id}/iterations/1/correction`);
  const figures = page.getByRole("table", { name: "Figures before, predicted and measured" }).locator("tbody tr");
  for (const [i, key] of ["profile_slope", "helix_slope", "profile_crowning", "helix_crowning", "twist"].entries()) {
    const expected = answer.figure_changes[`${key}_um`];
    const cells = figures.nth(i).locator("td .cell");
    agrees(await cells.nth(0).textContent(), expected.before.value_um);
    agrees(await cells.nth(1).textContent(), result.figures.left[`${key}_um`].target);
    agrees(await cells.nth(2).textContent(), expected.predicted_um);
    const places = (/** @type {string | null} */ text) => /\d+(?:\.(\d+))?/.exec(text ?? "")?.[1]?.length ?? 0;
    const [before, predicted] = [await cells.nth(0).textContent(), await cells.nth(2).textContent()];
    assert.equal(places(predicted), places(before), `${predicted} next to ${before}`);
    agrees(await cells.nth(3).textContent(), expected.measured.value_um);
    agrees(await cells.nth(4).textContent(), expected.change.value_um);
    agrees(await cells.nth(5).textContent(), expected.difference.value_um);
  }
  const rms = figures.nth(5).locator("td .cell");
  agrees(await rms.nth(0).textContent(), answer.rms_before_um);
  agrees(await rms.nth(2).textContent(), answer.rms_predicted_um);
  agrees(await rms.nth(3).textContent(), answer.rms_measured_um);
  agrees(await figures.nth(6).locator("td .cell").nth(2).textContent(), result.predicted.max_um);
  agrees(await page.locator("dt:text-is('Response ratio') + dd .figure").textContent(), answer.response_ratio);
  assert.equal(await page.locator(".heat-map").count(), 3, "before, predicted and measured");

  const waiting = page.waitForEvent("download");
  await page.getByRole("button", { name: "CSV for the controller" }).click();
  const text = await readFile(await (await waiting).path(), "utf8");
  assert.ok(text.startsWith("Identifier,CharacteristicIdentifier,CorrectionValueRelative"), text);
});

browserTest("a refusal is shown at its field, and no input is lost", { statuses: [422] }, async (world) => {
  const { page, open, loaded, job, iteration } = world;
  const { id } = await job();
  await iteration(id);
  await open(pathOf(id));
  const crowning = page.getByRole("group", { name: "Profile crowning" });
  await crowning.getByLabel("Minimum").fill("5");
  await crowning.getByLabel("Maximum").fill("1");
  await page.getByLabel("Target").selectOption("given");
  await page.getByLabel("Target deviations").fill("1 2 x");
  await page.getByRole("button", { name: "Compute the correction" }).click();
  await page.getByText("Not a number.").waitFor();
  await page.getByLabel("Target deviations").fill("1 2");
  await page.getByRole("button", { name: "Compute the correction" }).click();
  await crowning.locator(".field-error").waitFor();
  assert.equal(await crowning.getByLabel("Minimum").getAttribute("aria-invalid"), "true");
  await page.reload();
  await loaded();
  assert.equal(await crowning.getByLabel("Minimum").inputValue(), "5");
  assert.equal(await page.getByLabel("Target deviations").inputValue(), "1 2");
});

browserTest("a setting at its limit says so, and effects by a matrix have the caller's names", {}, async (world) => {
  const { page, open, loaded, job, iteration, call } = world;
  const { id } = await job();
  await iteration(id);
  const body = await request();
  body.limits.profile_angle = { min: -2, max: 2 };
  await call("POST", `/v1/jobs/${id}/iterations/1/correction`, body);
  await open(pathOf(id));
  await page.getByText("at its limit").waitFor();
  await page.getByText("New correction").click();
  await page.getByLabel("Effect of the settings").selectOption("matrix");
  const lines = Array.from(
    { length: 135 },
    (_, i) => `${(i % 15) / 7 - 1};${Math.floor(i / 15) / 4 - 1};${(Math.floor(i / 15) / 4 - 1) * 1.001}`,
  );
  await page.getByLabel("Sensitivity").fill(["a [µm];b [µm];<i>c</i> [µm]", ...lines].join("\n"));
  await page.getByRole("button", { name: "Compute the correction" }).click();
  await page.locator("dd", { hasText: "Sensitivity matrix" }).waitFor();
  await loaded();
  await page.getByText("The effects of b and <i>c</i> nearly cancel").waitFor();
  const names = page.getByRole("table", { name: "Changes of the machine settings" }).locator("tbody th .cell");
  assert.deepEqual(await names.allTextContents(), [
    "a ",
    "b indistinguishable from <i>c</i>",
    "<i>c</i> indistinguishable from b",
  ]);
});

browserTest(
  "what is within its limits is left, and the control gets nothing that would be outside",
  {},
  async (world) => {
    const { page, open, loaded, job, iteration, call } = world;
    const requirements = { tolerance_limits: { class: 6, profile_crowning_um: [2, 6], helix_crowning_um: [3, 9] } };
    const { id } = await job({ requirements });
    await iteration(id);
    await open(pathOf(id));
    await page.getByLabel("Effect of the settings").selectOption("form_grinding");
    await page.getByRole("button", { name: "Compute the correction" }).click();
    await page.getByText("middle of the limits").first().waitFor();
    await loaded();
    const { request: kept, result } = await call("GET", `/v1/jobs/${id}/iterations/1/correction`);
    assert.equal(kept.target, undefined, "the job's own, and no zeros");
    const changes = page.getByRole("table", { name: "Changes of the machine settings" }).locator("tbody tr");
    for (const [i, setting] of result.settings.entries())
      if (setting.unchanged) assert.equal(await changes.nth(i).locator("td .cell").first().textContent(), "no change");
    assert.ok(result.settings.some((/** @type {any} */ setting) => setting.unchanged));
    const figures = page.getByRole("table", { name: "Figures before and predicted" }).locator("tbody tr");
    const words = { conforms: "conforms", does_not_conform: "does not conform", undecidable: "undecidable" };
    const names = ["profile_slope", "helix_slope", "profile_crowning", "helix_crowning"];
    for (const [i, name] of names.entries()) {
      const expected = result.figures.left[`${name}_um`];
      const predicted = await figures.nth(i).locator("td .cell").nth(2).textContent();
      agrees(predicted, expected.predicted);
      assert.ok(
        predicted?.includes(words[/** @type {"conforms"} */ (expected.conformity_predicted.verdict)]),
        predicted ?? "",
      );
    }
    // a setting at its limit: the file is saved only after confirmation
    await call("POST", `/v1/jobs/${id}/iterations/1/correction`, {
      ...(await request()),
      limits: { helix_angle: { fixed: true }, profile_angle: { fixed: true } },
    });
    await page.reload();
    await page.getByText("predicted_outside_limits").waitFor();
    const asking = page.waitForEvent("dialog");
    const pressed = page.getByRole("button", { name: "CSV for the controller" }).click();
    const dialog = await asking;
    assert.match(dialog.message(), /outside the limits/);
    const waiting = page.waitForEvent("download");
    await dialog.accept();
    await pressed;
    assert.ok((await readFile(await (await waiting).path(), "utf8")).includes("Iterations"));
  },
);

browserTest("what was entered is kept, and the next measurement is compared with it", {}, async (world) => {
  const { page, open, loaded, job, iteration, call } = world;
  const { id } = await job();
  await iteration(id);
  await call("POST", `/v1/jobs/${id}/iterations/1/correction`, await request());
  await iteration(id, "flank_z52_remachined.json");
  await open(pathOf(id));
  const { result } = await call("GET", `/v1/jobs/${id}/iterations/1/correction`);
  const entered = page.getByRole("region", { name: "Entered on the machine" });
  const crowning = result.settings.find((/** @type {{ name: string }} */ { name }) => name === "helix_crowning");
  const change = entered.getByRole("group", { name: "Helix crowning" }).getByLabel("Change");
  agrees(await change.inputValue(), crowning.change);
  await change.fill("one");
  await entered.getByRole("button", { name: "Save entry" }).click();
  await entered.getByText("Not a number.").waitFor();
  await change.fill("−0,5");
  await entered.getByLabel("Note").fill("within its limits");
  await entered.getByRole("button", { name: "Save entry" }).click();
  const rows = entered.getByRole("table", { name: "Entered" }).locator("tbody tr");
  await rows.first().waitFor();
  await loaded();
  const { applied, answer } = await call("GET", `/v1/jobs/${id}/iterations/1/correction`);
  assert.equal(applied.note, "within its limits");
  for (const [i, setting] of applied.settings.entries()) {
    const proposed = result.settings[i];
    assert.equal(setting.change, setting.name === "helix_crowning" ? -0.5 : proposed.change, "the others as proposed");
    agrees(await rows.nth(i).locator("td .cell").nth(0).textContent(), setting.change);
  }
  const words = {
    as_predicted: "as predicted",
    weaker: "weaker",
    no_response: "no response",
    stronger: "stronger",
    different: "different from predicted",
    undecided: "undecided",
  };
  await page
    .getByText(`${words[/** @type {"weaker"} */ (answer.verdict)]}`, { exact: false })
    .first()
    .waitFor();
  await page.getByText("for the entered changes").waitFor();
  // the form starts with the values of the entry
  await entered.getByText("Edit entry").click();
  assert.equal(await change.inputValue(), "-0.5");
});

browserTest("a value before shows the one after, and the next correction goes on from it", {}, async (world) => {
  const { page, open, loaded, job, iteration, call } = world;
  const { id } = await job();
  await iteration(id);
  await call("POST", `/v1/jobs/${id}/iterations/1/correction`, await request());
  await open(pathOf(id));
  const entered = page.getByRole("region", { name: "Entered on the machine" });
  const angle = entered.getByRole("group", { name: "Profile angle" });
  const before = angle.getByLabel("Value before");
  await before.fill("2,03");
  await angle.getByLabel("Change").fill("14.89");
  await angle.getByRole("status", { name: "Value after" }).getByText("16.92 arcmin").waitFor();
  const helix = entered.getByRole("group", { name: "Helix angle" });
  assert.equal(await helix.getByLabel("Value after").textContent(), "–");
  await page.reload();
  await loaded();
  assert.equal(await before.inputValue(), "2,03");
  await entered.getByRole("button", { name: "Save entry" }).click();
  await entered.getByRole("table", { name: "Entered" }).waitFor();
  await entered.getByText("Edit entry").click();
  assert.equal(await before.inputValue(), "2,03", "before this correction");
  // typed after it was entered: its change is on the machine already
  await before.fill("3");
  await iteration(id, "flank_z52_remachined.json");
  await call("POST", `/v1/jobs/${id}/iterations/2/correction`, await request());
  await open(`/jobs/${id}/iterations/2/correction`);
  await before.waitFor();
  assert.equal(await before.inputValue(), "17.89", "3 and the change that was entered");
  await entered.getByRole("button", { name: "Save entry" }).click();
  await entered.getByText("Edit entry").click();
  assert.equal(await before.inputValue(), "17.89");
  // those of the earlier correction are no longer shown
  await open(pathOf(id));
  await entered.getByText("Edit entry").click();
  await angle.getByLabel("Change").fill("14.5");
  assert.equal(await before.count(), 0);
  await entered.getByRole("button", { name: "Save entry" }).click();
  await entered.getByRole("cell", { name: "+14.5" }).waitFor();
  await open(`/jobs/${id}/iterations/2/correction`);
  await entered.getByText("Edit entry").click();
  assert.equal(await before.inputValue(), "17.89", "nor written");
  // another job on the same machine has values of its own
  const other = await job();
  await iteration(other.id);
  await call("POST", `/v1/jobs/${other.id}/iterations/1/correction`, await request());
  await open(pathOf(other.id));
  await before.waitFor();
  assert.equal(await before.inputValue(), "");
});

browserTest("a change that means little is not bold, and each reason is said once", {}, async (world) => {
  const { page, open, loaded, job, iteration, call } = world;
  const { id } = await job();
  await iteration(id);
  await call("POST", `/v1/jobs/${id}/iterations/1/correction`, { ...(await request()), settings_used: "all" });
  await open(pathOf(id));
  const changes = page.getByRole("table", { name: "Changes of the machine settings" });
  await changes.waitFor();
  await loaded();
  const { result } = await call("GET", `/v1/jobs/${id}/iterations/1/correction`);
  const rows = changes.locator("tbody tr");
  let [unsure, sure] = [0, 0];
  for (const [i, setting] of result.settings.entries()) {
    if (setting.fixed || setting.undetermined || setting.unchanged || setting.limited) continue;
    const weight = await rows
      .nth(i)
      .locator(".change")
      .evaluate((one) => Number(getComputedStyle(one).fontWeight));
    const means = Math.abs(setting.change) > 1.96 * setting.std_error;
    assert.equal(weight > 500, means, `${setting.name}: ${setting.change} ± ${setting.std_error}`);
    if (means) sure += 1;
    else unsure += 1;
    if (setting.unit === "arcmin") assert.match((await rows.nth(i).locator(".change").textContent()) ?? "", /arcmin$/);
  }
  assert.ok(unsure > 0 && sure > 0, `${unsure} and ${sure}`);
  assert.ok(result.settings.filter((/** @type {any} */ one) => one.undetermined).length > 1);
  assert.equal(await page.getByText("not determined by this measurement").count(), 1);
  assert.equal(await page.getByText("indistinguishable from zero").count(), 1);
});

browserTest("a flank that the measurement does not name is said above the changes", {}, async (world) => {
  const { page, open, loaded, job, call } = world;
  const { flank: _, ...nodes } = JSON.parse(await example("flank_z52.json"));
  const { id } = await job();
  await call("POST", `/v1/jobs/${id}/iterations`, nodes);
  await open(pathOf(id));
  await page.getByLabel("Flank", { exact: true }).selectOption("right");
  await page.getByRole("button", { name: "Compute the correction" }).click();
  const panel = page.getByRole("region", { name: "Changes of the machine settings", exact: true });
  const banner = panel.getByText("the right flank was assumed for this correction");
  await banner.waitFor();
  await loaded();
  const above = (await banner.boundingBox())?.y ?? 0;
  assert.ok(above < ((await panel.getByRole("table").boundingBox())?.y ?? 0));
  await call("PATCH", `/v1/jobs/${id}/iterations/1`, { flank: "right" });
  await page.reload();
  await panel.waitFor();
  await loaded();
  assert.equal(await banner.count(), 0, "now the measurement names it");
  await call("PATCH", `/v1/jobs/${id}/iterations/1`, { flank: "left" });
  await page.reload();
  await panel.getByText("now assigned to the left flank; this correction is for the right flank").waitFor();
  assert.equal(await banner.count(), 0);
  // a request without a flank has that of the iteration
  const { id: named } = await job();
  await call("POST", `/v1/jobs/${named}/iterations`, { ...nodes, flank: "left" });
  await call("POST", `/v1/jobs/${named}/iterations/1/correction`, {
    sensitivity: { type: "machine", machine: "form_grinding" },
  });
  await open(pathOf(named));
  await panel.waitFor();
  await loaded();
  assert.equal(await panel.locator(".note.warn").count(), 0);
  await call("PATCH", `/v1/jobs/${named}/iterations/1`, { flank: "right" });
  await page.reload();
  await panel.getByText("now assigned to the right flank; this correction is for the left flank").waitFor();
});

browserTest("the other flank is predicted once it was measured", {}, async (world) => {
  const { page, open, loaded, job, iteration, call } = world;
  const { requirements } = JSON.parse(await example("requests/job_requirements.json"));
  const { id } = await job({ requirements });
  await iteration(id);
  await call("POST", `/v1/jobs/${id}/iterations/1/correction`, await request());
  await open(pathOf(id));
  const other = page.getByRole("region", { name: "The right flank", exact: true });
  await other.getByText("This flank has not been measured.").waitFor();
  assert.equal(await other.getByRole("table").count(), 0);

  await iteration(id, "flank_z52_right.json");
  await call("POST", `/v1/jobs/${id}/iterations/1/correction`, await request());
  await page.reload();
  await other.getByText("Predicted from iteration 2").waitFor();
  await loaded();
  const { figures } = (await call("GET", `/v1/jobs/${id}/iterations/1/correction`)).result.other_flank;
  const rows = other.getByRole("table", { name: "Figures before and predicted, The right flank" }).locator("tbody tr");
  const names = ["profile_slope", "helix_slope", "profile_crowning", "helix_crowning", "twist"];
  assert.equal(await rows.count(), names.length);
  const signs = { conforms: "✓", does_not_conform: "✗", undecidable: "?" };
  for (const [i, name] of names.entries()) {
    const expected = figures[`${name}_um`];
    const cells = rows.nth(i).locator("td .cell");
    agrees(await cells.nth(0).textContent(), expected.before);
    const predicted = await cells.nth(2).textContent();
    agrees(predicted, expected.predicted);
    assert.ok(
      predicted?.includes(signs[/** @type {"conforms"} */ (expected.conformity_predicted.verdict)]),
      `${name}: ${predicted}`,
    );
  }
});

browserTest("axe finds nothing in an open form", {}, async (world) => {
  const { page, open, job, iteration, call, accessible } = world;
  const { id } = await job();
  await iteration(id);
  await call("POST", `/v1/jobs/${id}/iterations/1/correction`, await request());
  await open(pathOf(id));
  await page.getByText("New correction").click();
  await accessible();
});

browserTest("in German with decimal commas", { settings: { language: "de" } }, async (world) => {
  const { page, open, job, iteration, call } = world;
  const { id } = await job();
  await iteration(id);
  await call("POST", `/v1/jobs/${id}/iterations/1/correction`, await request());
  await iteration(id, "flank_z52_remachined.json");
  await open(pathOf(id));
  await page.getByText("+14,9", { exact: false }).waitFor();
  await page.getByText("anders als vorhergesagt").waitFor();
});
