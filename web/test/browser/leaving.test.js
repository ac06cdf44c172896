// A request without a response is not sent again once its form is left or its dialog closed.

import assert from "node:assert/strict";
import { fileURLToPath } from "node:url";
import { browserTest, example } from "./harness.js";

/** @typedef {import("./harness.js").World} World */
/** @typedef {import("playwright-core").Page} Page */

const flank = fileURLToPath(new URL("../../../examples/flank_z52.json", import.meta.url));

/**
 * Sends a request that is lost each time, leaves, and lets a minute pass.
 * @param {Page} page @param {{ lost: string, send: () => Promise<void>, leave: () => Promise<void>, shown: string }} parts
 *   `lost`: where it is sent to; `shown`: the path of the page that is shown in the end
 */
async function leaves(page, { lost, send, leave, shown }) {
  await page.clock.install();
  let tries = 0;
  await page.route(lost, (route) => {
    if (route.request().method() !== "POST") return route.continue();
    tries += 1;
    return route.abort("connectionreset");
  });
  await send();
  await page.getByText("Your input is queued").waitFor();
  await leave();
  await page.getByText("Cancelled. Data that had already arrived may be stored").waitFor();
  const left = tries;
  assert.ok(left > 0 && left < 5, `it was tried ${left} times`);
  await page.clock.runFor(60_000);
  assert.equal(tries, left);
  assert.equal(new URL(page.url()).pathname, shown);
}

/** @param {Page} page */
const toJobs = (page) => page.getByRole("link", { name: "Jobs", exact: true }).first().click();

browserTest("a new job", { offline: true }, async ({ page, open, call }) => {
  await open("/jobs/new");
  await page.getByLabel("With gear data").uncheck();
  await page.getByLabel("Name", { exact: true }).fill("Left");
  await leaves(page, {
    lost: "**/v1/jobs",
    send: () => page.getByRole("button", { name: "Create the job" }).click(),
    leave: () => page.getByRole("link", { name: "Cancel" }).click(),
    shown: "/jobs",
  });
  assert.deepEqual((await call("GET", "/v1/jobs")).items, []);
});

browserTest("an evaluation", { offline: true }, async ({ page, open, job, iteration, call }) => {
  const { id } = await job();
  await iteration(id);
  const evaluations = `/v1/jobs/${id}/iterations/1/evaluations`;
  await call("POST", evaluations, JSON.parse(await example("requests/gear_evaluate.json")));
  await open(`/jobs/${id}/iterations/1/evaluation`);
  await page.getByText("Evaluate with different ranges, sign or class").click();
  await page.getByLabel("Required class").selectOption("6");
  await leaves(page, {
    lost: "**/evaluations",
    send: () => page.getByRole("button", { name: "Evaluate", exact: true }).click(),
    leave: () => toJobs(page),
    shown: "/jobs",
  });
  assert.equal((await call("GET", `/v1/jobs/${id}/iterations/1/records`)).items.length, 1);
});

browserTest("nodes of a fit that are saved", { offline: true }, async ({ page, open, loaded, job, call }) => {
  const { id } = await job();
  await open("/fit");
  await page.getByLabel("Drop a file here").setInputFiles(flank);
  await page.getByRole("heading", { name: "Save as iteration" }).waitFor();
  await loaded();
  await page.getByLabel("Job", { exact: true }).selectOption(id);
  await leaves(page, {
    lost: "**/iterations",
    send: () => page.getByRole("button", { name: "Save", exact: true }).click(),
    leave: () => toJobs(page),
    shown: "/jobs",
  });
  assert.deepEqual((await call("GET", `/v1/jobs/${id}/trace`)).iterations, []);
});

browserTest("a refit that is kept, whose dialog is closed", { offline: true }, async (world) => {
  const { page, open, loaded, job, iteration, call } = world;
  const { id } = await job();
  await iteration(id);
  const path = `/jobs/${id}/iterations/1/lambda`;
  await open(`${path}?lambda=1e-3`);
  await loaded();
  await page.getByRole("button", { name: "Store", exact: true }).click();
  const dialog = page.getByRole("dialog");
  await dialog.getByLabel("Reason").fill("not meant");
  await leaves(page, {
    lost: "**/fits",
    send: () => dialog.getByRole("button", { name: "Store" }).click(),
    leave: () => page.keyboard.press("Escape"),
    shown: path,
  });
  // the input stays, to be sent or not
  assert.equal(await dialog.getByLabel("Reason").inputValue(), "not meant");
  assert.equal((await call("GET", `/v1/jobs/${id}/iterations/1`)).fits.length, 1);
});
