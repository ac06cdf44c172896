// The correction of the gear on the page of its job: from both flanks, entered on the machine,
// saved for its controller.

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { browserTest, example } from "./harness.js";
import { agrees } from "./numbers.js";
import { gearCorrected } from "./pages.js";

const FIGURES = ["profile_slope", "helix_slope", "profile_crowning", "helix_crowning", "twist"];
const SIGNS = { conforms: "✓", does_not_conform: "✗", undecidable: "?" };

/** @param {string} side */
const figuresOf = (side) => `Figures before and predicted, ${side} flank`;

browserTest("settings for both flanks are computed from the mean over their teeth", {}, async (world) => {
  const { page, open, loaded, job, iteration, call } = world;
  const { requirements } = JSON.parse(await example("requests/job_requirements.json"));
  const { id } = await job({ requirements });
  await open(`/jobs/${id}`);
  assert.equal(await page.getByRole("region", { name: "Correct the gear" }).count(), 0, "nothing was measured");
  await iteration(id);
  await iteration(id, "flank_z52_right.json");
  await page.reload();
  const panel = page.getByRole("region", { name: "Correct the gear (all teeth)", exact: true });
  await panel.getByLabel("Grinding method").selectOption("Generating grinding");
  await panel.getByRole("button", { name: "Compute the correction" }).click();
  const changes = panel.getByRole("table", { name: "Changes of the machine settings" });
  await changes.waitFor();
  await loaded();
  const { result, method } = await call("GET", `/v1/jobs/${id}/correction`);
  assert.equal(method, "generating_grinding");
  const fact = (/** @type {string} */ name) => panel.locator(`dt:text-is('${name}') + dd`).textContent();
  assert.deepEqual(await Promise.all(["Machine", "Target", "Left flank", "Right flank"].map(fact)), [
    "Generating grinding",
    "design of the job",
    "one tooth",
    "one tooth",
  ]);
  const rows = changes.locator("tbody tr");
  assert.equal(await rows.count(), result.settings.length);
  for (const [i, setting] of result.settings.entries()) {
    const cells = rows.nth(i).locator("th .cell, td .cell");
    const name = (await cells.nth(0).textContent()) ?? "";
    assert.ok(name.includes(setting.name) && !/, (left|right)/.test(name), name);
    if (setting.fixed || setting.undetermined || setting.unchanged) continue;
    agrees(await cells.nth(1).textContent(), setting.change);
  }
  for (const side of ["left", "right"]) {
    const figures = panel.getByRole("table", { name: figuresOf(side === "left" ? "Left" : "Right") });
    assert.equal(await figures.locator("tbody tr").count(), FIGURES.length, "RMS is of both flanks together");
    for (const [i, key] of FIGURES.entries()) {
      const expected = result.figures[side][`${key}_um`];
      const cells = figures.locator("tbody tr").nth(i).locator("td .cell");
      const [before, wanted, predicted] = [await cells.nth(0).textContent(), cells.nth(1), cells.nth(2)];
      agrees(before, expected.before);
      agrees(await wanted.textContent(), expected.target);
      agrees(await predicted.textContent(), expected.predicted);
      const sign = (/** @type {string | undefined} */ decision) =>
        decision ? SIGNS[/** @type {"conforms"} */ (decision)] : "";
      assert.ok(before?.includes(sign(expected.conformity_before.verdict)), `${key}: ${before}`);
      assert.ok((await predicted.textContent())?.includes(sign(expected.conformity_predicted.verdict)), key);
    }
    // f_Hα is outside class 6, and the change brings it into its limits
    const slope = figures.locator("tbody tr").first().locator("td .cell");
    assert.match((await slope.nth(0).textContent()) ?? "", /✗/);
    assert.match((await slope.nth(2).textContent()) ?? "", /✓/);
  }
});

browserTest("settings of one flank say which, and what was entered is compared", {}, async (world) => {
  const { page, open, loaded, iteration, call } = world;
  const id = await gearCorrected(world);
  await open(`/jobs/${id}`);
  const panel = page.getByRole("region", { name: "Correct the gear (all teeth)", exact: true });
  const names = panel.getByRole("table", { name: "Changes of the machine settings" }).locator("tbody th .cell");
  const { result } = await call("GET", `/v1/jobs/${id}/correction`);
  const words = { profile_angle: "Profile angle", profile_crowning: "Profile crowning", helix_angle: "Helix angle" };
  const named = (await names.allTextContents()).map((text) => text.trim());
  for (const [name, word] of Object.entries(words)) {
    const own = result.settings.filter((/** @type {any} */ setting) => setting.name.startsWith(name));
    const expected = own.map((/** @type {any} */ setting) => {
      const side = /_(left|right)$/.exec(setting.name)?.[1];
      return `${word}${side ? `, ${side}` : ""} ${setting.name}`;
    });
    assert.deepEqual(
      named.filter((text) => text.startsWith(word)),
      expected,
    );
  }
  const waiting = page.waitForEvent("download");
  await panel.getByRole("button", { name: "CSV for the controller" }).click();
  const file = await readFile(await (await waiting).path(), "utf8");
  const response = await fetch(`${world.server.url}/v1/jobs/${id}/correction`, { headers: { accept: "text/csv" } });
  assert.equal(file, await response.text());
  const first = file.split("\r\n").map((line) => line.split(",")[0]);
  assert.deepEqual(first.slice(1, 3), ["profile_angle_left", "profile_angle_right"]);

  await panel.getByRole("group", { name: "Profile angle, left" }).getByLabel("Change").fill("15");
  await panel.getByLabel("Note").fill("rounded at the control");
  await panel.getByRole("button", { name: "Save entry" }).click();
  const entered = panel.getByRole("table", { name: "Entered" }).locator("tbody tr");
  await entered.first().waitFor();
  await loaded();
  const { applied } = await call("GET", `/v1/jobs/${id}/correction`);
  assert.equal(applied.note, "rounded at the control");
  for (const [i, setting] of applied.settings.entries()) {
    assert.equal(setting.change, setting.name === "profile_angle_left" ? 15 : setting.proposed);
    agrees(await entered.nth(i).locator("td .cell").first().textContent(), setting.change);
  }
  await iteration(id, "flank_z52_remachined.json");
  await iteration(id, "flank_z52_right_remachined.json");
  await page.reload();
  await panel.getByRole("heading", { name: "Response of the machine" }).waitFor();
  await loaded();
  const { answer } = await call("GET", `/v1/jobs/${id}/correction`);
  agrees(await panel.locator("dt:text-is('Response ratio') + dd .figure").textContent(), answer.response_ratio);
  for (const side of ["left", "right"]) {
    const name = `Figures before, predicted and measured, ${side === "left" ? "Left" : "Right"} flank`;
    const cells = panel.getByRole("table", { name }).locator("tbody tr").first().locator("td .cell");
    agrees(await cells.nth(3).textContent(), answer.flanks[side].profile_slope_um.measured.value_um);
  }
});
