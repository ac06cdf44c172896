// Single keys: they lead from iteration to iteration in the current view, and can be turned off.

import assert from "node:assert/strict";
import { browserTest } from "./harness.js";

/** @param {import("./harness.js").World} world */
async function twoIterations({ job, iteration }) {
  const { id } = await job();
  await iteration(id);
  await iteration(id, "flank_z52_remachined.json");
  return id;
}

browserTest("[ and ] lead to the same view of the iteration before and after", {}, async (world) => {
  const { page, open, loaded } = world;
  const id = await twoIterations(world);
  const iteration = (/** @type {number} */ number) => `/jobs/${id}/iterations/${number}`;
  for (const view of ["/lambda", "/statistics", "/correction", ""]) {
    await open(`${iteration(1)}${view}`);
    await page.keyboard.press("]");
    await page.waitForURL(`**${iteration(2)}${view}`);
    await loaded();
    // no further link after the last
    await page.keyboard.press("]");
    assert.equal(new URL(page.url()).pathname, `${iteration(2)}${view}`);
    await page.keyboard.press("[");
    await page.waitForURL(`**${iteration(1)}${view}`);
  }
  // views without an iteration lead to a map
  await open(`/jobs/${id}`);
  await page.keyboard.press("[");
  await page.waitForURL(`**${iteration(2)}`);
});

browserTest(
  "shortcuts that are switched off do nothing, and can be switched on",
  { settings: { shortcuts: false } },
  async (world) => {
    const { page, open, loaded } = world;
    const id = await twoIterations(world);
    const dialog = page.getByRole("dialog", { name: "Keyboard shortcuts" });
    const place = `/jobs/${id}/iterations/1`;
    await open(place);
    for (const key of ["?", "]", "+"]) await page.keyboard.press(key);
    assert.equal(await dialog.count(), 0);
    assert.equal(new URL(page.url()).pathname + new URL(page.url()).search, place);
    await open("/jobs");
    await page.keyboard.press("/");
    assert.equal(await page.getByLabel("Search").evaluate((one) => one === document.activeElement), false);

    await open("/settings");
    await page.getByLabel("Single-key shortcuts").check();
    await open("/jobs");
    await page.keyboard.press("/");
    assert.equal(await page.getByLabel("Search").evaluate((one) => one === document.activeElement), true);
    await open(place);
    await page.keyboard.press("?");
    await dialog.waitFor();
    await page.keyboard.press("Escape");
    await dialog.waitFor({ state: "detached" });
    await page.keyboard.press("]");
    await page.waitForURL(`**/jobs/${id}/iterations/2`);
    await loaded();
  },
);
