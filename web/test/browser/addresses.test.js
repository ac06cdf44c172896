// The address has all choices; nightly/sweep.test.js loads every page anew.

import assert from "node:assert/strict";
import { browserTest, example } from "./harness.js";

/** The content of the page. @param {import("playwright-core").Page} page */
const seen = async (page) => ((await page.locator("main").textContent()) ?? "").replaceAll(/\s+/gu, " ").trim();

browserTest("the address has the choices made on a page", {}, async (world) => {
  const { page, open, loaded, job, iteration, call } = world;
  const { id } = await job();
  await iteration(id);
  await iteration(id, "flank_z52_remachined.json");
  await call("POST", `/v1/jobs/${id}/iterations/1/evaluations`, await example("requests/gear_evaluate.json"));
  const at = `/jobs/${id}/iterations/1`;
  /** @type {[string, () => Promise<unknown>][]} */
  const choices = [
    [at, () => page.getByRole("button", { name: "Contours" }).click()],
    [at, () => page.getByRole("button", { name: "3-D" }).click()],
    [`${at}/lambda`, () => page.getByRole("button", { name: "Show the refit by gcv" }).click()],
    [`${at}/evaluation`, () => page.getByLabel("Class of the K-band").selectOption("6")],
    [`/jobs/${id}/trace`, () => page.getByLabel("Records").uncheck()],
    ["/jobs", () => page.getByLabel("Sort by").selectOption("name")],
  ];
  for (const [path, choose] of choices) {
    await open(path);
    const plain = page.url();
    await choose();
    await page.waitForURL((url) => url.href !== plain);
    await loaded();
    const [address, text] = [page.url(), await seen(page)];
    await open("/settings");
    await page.goto(address);
    await loaded();
    assert.equal(await seen(page), text, path);
  }
});
