// The layer of all teeth: deviations that were kept, each flank on one scale, compared.

import assert from "node:assert/strict";
import { browserTest, example } from "./harness.js";
import { agrees } from "./numbers.js";

/** Flanks with their factors: 2 left is that of the example, doubled. */
const FLANKS = /** @type {const} */ ([
  [2, "left", 2],
  [1, "right", -1],
  [1, "left", 1],
]);

browserTest("all teeth are side by side, and the figures are the interface's", {}, async (world) => {
  const { page, open, job, call, loaded } = world;
  const { id } = await job();
  // an iteration that is of no tooth may have deviations of any
  const { flank: _, tooth: __, ...measured } = JSON.parse(await example("flank_z52.json"));
  await call("POST", `/v1/jobs/${id}/iterations`, measured);
  const place = `/v1/jobs/${id}/iterations/1`;
  await open(`/jobs/${id}/iterations/1`);
  assert.equal(await page.getByLabel("Layer").locator("option", { hasText: "All teeth" }).count(), 0);

  const sent = JSON.parse(await example("requests/iteration_deviations.json"));
  /** @type {Record<string, any>} */
  const answers = {};
  for (const [tooth, flank, factor] of FLANKS) {
    const heights = sent.grid.deviation_um.map((/** @type {(number | null)[]} */ row) =>
      row.map((z) => (z === null ? null : factor * z)),
    );
    const grid = { ...sent.grid, tooth, flank, deviation_um: heights };
    const { result } = await call("POST", `${place}/deviations`, { ...sent, grid });
    answers[`Tooth ${tooth}, ${flank}`] = result;
  }
  await open(`/jobs/${id}/iterations/1`);
  await page.getByLabel("Layer").selectOption({ label: "All teeth" });
  await loaded();
  await page.getByText("3 flanks of 2 teeth, on a common scale.").waitFor();
  const rows = page.getByRole("table", { name: "All teeth" }).locator("tbody tr");
  const names = ["Tooth 1, left", "Tooth 2, left", "Tooth 1, right"];
  for (const [i, name] of names.entries()) {
    const expected = answers[name].deviation_um.filter((/** @type {unknown} */ z) => z !== null);
    const cells = await rows.nth(i).locator(".cell").allTextContents();
    assert.equal(cells[0], name, "left flanks first, teeth in their order");
    agrees(cells[1], expected.length);
    agrees(cells[2], Math.min(...expected));
    agrees(cells[3], Math.max(...expected));
    agrees(
      cells[4],
      expected.reduce((/** @type {number} */ sum, /** @type {number} */ z) => sum + z, 0) / expected.length,
    );
  }

  // one line for each flank, the picked one thick; through the middle of the width the nodes themselves
  const profiles = page.getByRole("figure", { name: "Profile sections of all teeth" });
  assert.equal(await profiles.locator(".mark-line.thin").count(), 2);
  assert.equal(await profiles.locator(".mark-line:not(.thin)").count(), 1);
  assert.equal(await profiles.locator(".mark-line[stroke-dasharray]").count(), 1, "right flanks are dashed");
  await profiles.getByRole("button", { name: "As table" }).click();
  const of = answers["Tooth 2, left"];
  const middle = of.deviation_um.filter((/** @type {unknown} */ _, /** @type {number} */ i) => of.z_mm[i] === 7.5);
  const shown = await profiles
    .locator("tbody tr", { hasText: "Tooth 2, left" })
    .locator("td:last-child .cell")
    .allTextContents();
  assert.equal(shown.length, middle.length);
  for (const [i, value] of middle.entries()) agrees(shown[i], value);

  // another tooth, large; the address has it
  await page.getByRole("button", { name: /^Tooth 2, left/ }).click();
  await page.getByRole("heading", { name: "Tooth 2, left" }).waitFor();
  assert.equal(new URL(page.url()).searchParams.get("tooth"), "2-left");
  await page.reload();
  await loaded();
  const least = Math.min(...of.deviation_um.filter((/** @type {unknown} */ z) => z !== null));
  agrees((await page.locator("[data-extreme=least]").textContent())?.split(" · ")[2], least);

  // a flank measured again: the last one counts
  const again = { ...sent, grid: { ...sent.grid, tooth: 2, flank: "left" } };
  await call("POST", `${place}/deviations`, again);
  await page.reload();
  await loaded();
  assert.equal(await rows.count(), 3);
  agrees(
    await rows.nth(1).locator("td .cell").nth(1).textContent(),
    Math.min(...answers["Tooth 1, left"].deviation_um),
  );
});

browserTest(
  "points of a measured gear are parted by tooth and flank",
  {},
  async ({ page, open, job, iteration, call }) => {
    const sent = JSON.parse(await example("requests/gear_deviations.json"));
    const { id } = await job({ gear: sent.gear });
    await iteration(id);
    const { result } = await call("POST", `/v1/jobs/${id}/iterations/1/deviations`, sent);
    const keys = new Set(
      result.tooth.map((/** @type {number} */ tooth, /** @type {number} */ i) => `${tooth}-${result.flank[i]}`),
    );
    await open(`/jobs/${id}/iterations/1?layer=teeth`);
    assert.equal(await page.locator(".tooth-map").count(), keys.size);
    const cells = page.getByRole("table", { name: "All teeth" }).locator("tbody td:nth-child(2) .cell");
    const counts = (await cells.allTextContents()).map(Number);
    const expected = result.deviation_um.filter((/** @type {unknown} */ z) => z !== null).length;
    assert.equal(
      counts.reduce((sum, one) => sum + one, 0),
      expected,
    );
  },
);
