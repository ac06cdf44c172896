// A gear from the new job to the printed report, by pointer and by keyboard alone: the pages show
// the interface's numbers at each step.

import assert from "node:assert/strict";
import { execFile } from "node:child_process";
import path from "node:path";
import { promisify } from "node:util";
import { formats } from "../../app/lib/format.js";
import { keyboard, pointer } from "./hands.js";
import { browserTest, example } from "./harness.js";

const run = promisify(execFile);
const f = formats("en");

/** @param {import("./harness.js").World} world @param {import("./hands.js").Hands} hands */
async function story(world, { press, type, pick }) {
  const { page, open, loaded, call, server } = world;
  const button = (/** @type {string} */ name) => page.getByRole("button", { name, exact: true });
  const link = (/** @type {string} */ name) => page.getByRole("link", { name, exact: true });
  const dialog = page.getByRole("dialog");
  const decide = async (/** @type {string} */ action, /** @type {string} */ reason) => {
    await press(button(action));
    await type(dialog.getByLabel("Reason"), reason);
    await press(dialog.getByRole("button", { name: action, exact: true }));
    await dialog.waitFor({ state: "detached" });
  };
  const measure = async (/** @type {string} */ name) => {
    await press(page.getByRole("navigation", { name: "Views of this job" }).getByRole("link", { name: "Measure" }));
    await page.waitForURL("**/measure");
    await loaded();
    const picker = page.locator("#measure-files");
    await pick(picker, { name, mimeType: "application/json", buffer: Buffer.from(await example(name)) });
    await page.locator(".queue-entry canvas").waitFor();
    await press(button("Store as iteration"));
  };

  // a new job
  const gear = JSON.parse(await example("requests/job.json")).gear;
  await open("/jobs");
  await press(link("New job").first());
  await page.getByRole("heading", { name: "New job" }).waitFor();
  await loaded();
  for (const [label, text] of [
    ["Name", "Pump gear <b>A</b>"],
    ["Part number", "97340"],
    ["Machine", "form grinder 3"],
    ["Teeth z", String(gear.teeth)],
    ["Normal module", String(gear.normal_module_mm)],
    ["Pressure angle", String(gear.normal_pressure_angle_deg)],
    ["Profile shift", String(gear.profile_shift_coefficient)],
    ["Face width", String(gear.face_width_mm)],
  ])
    await type(page.getByLabel(label ?? "", { exact: label === "Name" }), text ?? "");
  await press(button("Create the job"));
  await page.getByRole("heading", { name: "Pump gear <b>A</b>" }).waitFor();
  await loaded();
  const id = new URL(page.url()).pathname.split("/")[2] ?? "";
  const at = `/v1/jobs/${id}/iterations`;

  // measured: the map names its least and its greatest node
  await measure("flank_z52.json");
  await page.waitForURL(`**/jobs/${id}/iterations/1`);
  await loaded();
  const { z } = await call("GET", `${at}/1/nodes`);
  const heights = z.flat().filter((/** @type {number | null} */ height) => height !== null);
  for (const [name, value] of [
    ["least", Math.min(...heights)],
    ["greatest", Math.max(...heights)],
  ])
    await page.locator(`[data-extreme="${name}"]`, { hasText: `${f.um(Number(value))} µm` }).waitFor();

  // λ* by gcv: stored, and chosen
  await press(link("λ*"));
  await page.waitForURL("**/lambda");
  await loaded();
  await press(button("Show the refit by gcv"));
  await page.getByText("not stored").waitFor();
  await loaded();
  await press(button("Store"));
  await type(dialog.getByLabel("Reason"), "GCV agrees with the error budget");
  await press(dialog.getByRole("button", { name: "Store", exact: true }));
  await page.getByText("The refit has been stored.").waitFor();
  await loaded();
  await press(button("Choose this fit"));
  await type(dialog.getByLabel("Reason"), "as agreed");
  await press(dialog.getByRole("button", { name: "Choose this fit", exact: true }));
  await page.getByText("This fit is now the chosen one.").waitFor();
  await loaded();

  // machine again
  await press(link("Flank map"));
  await page.waitForURL(/iterations\/1$/);
  await loaded();
  await decide("Machine again", "profile slope beyond class 5");
  await page.getByText("Decided: machine again.").waitFor();

  // the correction
  await press(link("Correction"));
  await page.waitForURL("**/correction");
  await loaded();
  await press(button("Compute the correction"));
  await page.locator("#changes").waitFor();
  await loaded();
  const { result } = await call("GET", `${at}/1/correction`);
  const changes = page.getByRole("region", { name: (await page.locator("#changes").textContent()) ?? "" });
  for (const { name, change, std_error: error } of result.settings) {
    if (!error) continue;
    const row = changes.getByRole("row").filter({ hasText: name });
    await row.filter({ hasText: f.deviation(Math.abs(change), undefined, error) }).waitFor();
    await row.filter({ hasText: `± ${f.significant(error, 2)}` }).waitFor();
  }

  // measured again: before, predicted, measured
  await measure("flank_z52_remachined.json");
  await page.waitForURL(`**/jobs/${id}/iterations/2`);
  await loaded();
  await page.goto(`${server.url}/jobs/${id}/iterations/1/correction`);
  await loaded();
  const { answer } = await call("GET", `${at}/1/correction`);
  const figures = page.locator('section[aria-labelledby="figures"]');
  for (const { before, predicted_um: predicted, measured } of /** @type {any[]} */ (
    Object.values(answer.figure_changes)
  )) {
    for (const one of [before, measured])
      await figures.getByText(f.withError(one.value_um, one.std_error_um)).first().waitFor();
    await figures
      .getByText(f.deviation(predicted, "µm", before.std_error_um), { exact: true })
      .first()
      .waitFor();
  }

  // accepted
  await press(link("Iteration 2"));
  await page.waitForURL(/iterations\/2$/);
  await loaded();
  await decide("Accept", "within the drawing");
  await page.getByText("Decided: accepted.").waitFor();
  const { iterations } = await call("GET", `/v1/jobs/${id}/trace`);
  const [first, second] = iterations;
  assert.deepEqual([first.decision, second.decision], ["remachine", "accepted"]);
  assert.equal(first.fits.find((/** @type {any} */ fit) => fit.chosen).criterion, "gcv");

  // the trace has it
  await press(link("Trace"));
  await page.waitForURL("**/trace");
  await loaded();
  const text = (await page.locator(".trace-entries").textContent()) ?? "";
  for (const word of ["GCV agrees with the error budget", "as agreed", "beyond class 5", "within the drawing"])
    assert.ok(text.includes(word), word);

  // on paper
  await press(link("Report"));
  await page.waitForURL("**/report");
  await loaded();
  await page.getByRole("button", { name: "Print", disabled: false }).waitFor();
  const pdf = path.join(server.folder, "story.pdf");
  await page.pdf({ path: pdf, preferCSSPageSize: true, printBackground: true });
  const { stdout } = await run("pdftotext", ["-layout", pdf, "-"], { maxBuffer: 1 << 26 });
  const pages = stdout.split("\f").map((text) => text.replaceAll(/\s+/gu, " "));
  const cover = pages[0] ?? "";
  const chosen = second.fits.find((/** @type {any} */ fit) => fit.chosen);
  for (const word of ["Pump gear <b>A</b>", "97340", "accepted", "within the drawing", "Signature"])
    assert.ok(cover.includes(word), `${word} in ${cover}`);
  for (const number of [f.three(chosen.rms), f.three(chosen.lambda_star)])
    assert.ok(cover.includes(number), `${number} in ${cover}`);
  assert.ok(!(pages[1] ?? "").includes("Signature"), "the first page is one page");
}

browserTest("the story of a gear", {}, (world) => story(world, pointer(world.page)));
browserTest("the story of a gear, by keyboard alone", {}, (world) => story(world, keyboard(world.page)));
