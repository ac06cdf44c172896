// Languages, the keyboard, files of another release, less motion. nightly/sweep.test.js visits every page.

import assert from "node:assert/strict";
import { browserTest } from "./harness.js";

browserTest(
  "German has its words and its comma",
  { settings: { language: "de" } },
  async ({ page, open, loaded, job, iteration, call }) => {
    const { id } = await job();
    await iteration(id);
    await open(`/jobs/${id}`);
    await page.getByText("Über Iteration 1 entscheiden").waitFor();
    assert.equal(await page.locator("html").getAttribute("lang"), "de");
    const { iterations } = await call("GET", `/v1/jobs/${id}/trace`);
    const rms = iterations[0].fits[0].rms.toPrecision(3).replace(".", ",");
    assert.ok(((await page.getByRole("table", { name: "Iterationen" }).textContent()) ?? "").includes(rms), rms);
    await page.getByRole("link", { name: "Einstellungen" }).click();
    await page.getByLabel("Sprache").selectOption("en");
    await page.getByRole("heading", { name: "Settings" }).waitFor();
    await page.getByLabel("Theme").selectOption("dark");
    await page.reload();
    await loaded();
    await page.getByRole("heading", { name: "Settings" }).waitFor();
    assert.equal(await page.locator("html").getAttribute("data-theme"), "dark");
  },
);

browserTest("the keyboard leads everywhere", {}, async ({ page, open, job }) => {
  await job({ name: "by keys" });
  await open("/jobs");
  await page.evaluate(() => document.activeElement instanceof HTMLElement && document.activeElement.blur());
  await page.keyboard.press("Tab");
  await page.waitForFunction(() => document.activeElement?.textContent === "Skip to content");
  await page.keyboard.press("Enter");
  // the browser moves the focus behind the next frame
  await page.waitForFunction(() => document.activeElement?.id === "content");
  await page.keyboard.press("?");
  const dialog = page.getByRole("dialog", { name: "Keyboard shortcuts" });
  await dialog.getByText("Show this list").waitFor();
  await page.keyboard.press("Escape");
  await dialog.waitFor({ state: "detached" });
  await page.getByRole("link", { name: "by keys" }).focus();
  await page.keyboard.press("Enter");
  await page.getByRole("heading", { name: "by keys" }).waitFor();
  await page.getByRole("button", { name: "Edit" }).focus();
  await page.keyboard.press("Enter");
  await page.getByRole("dialog", { name: "Edit the job" }).waitFor();
  await page.keyboard.press("Escape");
  await page.getByRole("dialog").waitFor({ state: "detached" });
  // the focus comes back
  await page.waitForFunction(() => document.activeElement?.textContent === "Edit");
});

browserTest(
  "where the server has other files by now, the page offers to reload",
  { statuses: [404] },
  async ({ page, open }) => {
    await open("/jobs");
    await page.route("**/app/pages/settings.js", (route) => route.fulfill({ status: 404, body: "" }));
    await page.getByRole("link", { name: "Settings" }).click();
    await page.getByText("A new version of the dashboard is available.").waitFor();
    await page.unroute("**/app/pages/settings.js");
    await page.getByRole("button", { name: "Reload" }).click();
    await page.getByRole("heading", { name: "Settings" }).waitFor();
  },
);

browserTest(
  "who wants less motion has none",
  { context: { reducedMotion: "no-preference" } },
  async ({ page, open }) => {
    await open("/jobs");
    // as any style of a page might set it
    const moving = () =>
      page.evaluate(() => {
        const [page, one] = [document.documentElement, document.body];
        Object.assign(page.style, { scrollBehavior: "smooth" });
        Object.assign(one.style, { transition: "opacity 3s", animation: "appear 3s" });
        const style = getComputedStyle(one);
        const { transitionDuration, animationDuration } = style;
        return [transitionDuration, animationDuration, getComputedStyle(page).scrollBehavior];
      });
    assert.deepEqual(await moving(), ["3s", "3s", "smooth"]);
    await page.emulateMedia({ reducedMotion: "reduce" });
    const [transition, animation, scroll] = await moving();
    assert.equal(transition, "0s");
    assert.ok(Number.parseFloat(animation ?? "") <= 0.001, animation);
    assert.equal(scroll, "auto");
  },
);
