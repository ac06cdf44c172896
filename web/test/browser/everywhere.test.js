// What holds of every page: accessibility, languages, narrow screens, the keyboard.

import assert from "node:assert/strict";
import { asTables, graphics } from "./graphics.js";
import { axeFinds, browserTest } from "./harness.js";
import { jumps, pressed, show, strays, watchShifts, wide } from "./looks.js";
import { closes, opens, pageList, visit } from "./pages.js";

/** @typedef {import("./harness.js").World} World */
/** @typedef {import("playwright-core").Page} Page */

const DESK = { width: 1280, height: 800 };
/** A tablet is turned: both widths are of one. */
const TABLETS = [
  { width: 1000, height: 1024 },
  { width: 768, height: 1024 },
];
const PHONE = { width: 360, height: 740 };

/** What a reader of the page has before them. @param {Page} page */
const seen = async (page) => ((await page.locator("main").textContent()) ?? "").replaceAll(/\s+/gu, " ").trim();

/**
 * The faults of what is shown, by all that holds of pages and dialogs: window, theme and language are changed and set
 * back. Each theme is looked at by axe, and each width: light on the desk, dark on a tablet.
 * @param {World} world @param {string} [part] that axe looks at, by default the page
 */
async function looked(world, part) {
  const { page } = world;
  /** @type {string[]} */
  const faults = [];
  const add = (/** @type {string} */ where, /** @type {readonly string[]} */ found) =>
    faults.push(...found.map((one) => `${where}: ${one}`));
  add("axe, light", await axeFinds(page, part));
  await show(world, { language: "pseudo" });
  add("not of the tables", await strays(page));
  await show(world, { language: "de" }, PHONE);
  add("360 px, de", await wide(page));
  await show(world, { language: "en", theme: "dark" });
  add("360 px, en", await wide(page));
  for (const tablet of TABLETS) {
    await show(world, {}, tablet);
    const { small, count } = await pressed(page);
    add(`less than 44 px at ${tablet.width} px`, small);
    if (count <= 4) add(`${tablet.width} px`, [`only ${count} targets`]);
  }
  add("axe, dark, on a tablet", await axeFinds(page, part));
  await show(world, { theme: "light" }, DESK);
  return faults;
}

browserTest("every page stands, in each theme, language and width", { settings: { theme: "light" } }, async (world) => {
  const { page, server, stands } = world;
  /** @type {string[]} */
  const faults = [];
  await watchShifts(page);
  let drawn = 0;
  for (const listed of await pageList(world)) {
    const add = (/** @type {readonly string[]} */ found, name = listed.name) =>
      faults.push(...found.map((one) => `${name}: ${one}`));
    const address = server.url + listed.path;
    add(await jumps(page, () => world.open(listed.path)));
    if (listed.fill) await visit(world, listed);
    const before = await seen(page);
    if (page.url() !== address) add([`stands at ${page.url()}`]);
    add(await looked(world));
    // what is seen stands in the address
    if (!listed.fill) {
      await page.reload();
      await stands();
      if (page.url() !== address) add([`stands at ${page.url()} after a reload`]);
    }
    const after = await seen(page);
    if (after !== before) add([`${before}\nis after a reload, or other languages and widths\n${after}`]);
    for (const dialog of listed.dialogs ?? []) {
      await opens(world, dialog);
      add(await looked(world, "dialog[open]"), dialog.name);
      await closes(world);
    }
    if (listed.name.startsWith("report")) continue;
    const { faults: found, count } = await graphics(page);
    add(found);
    drawn += count;
    await asTables(page);
  }
  assert.deepEqual(faults, []);
  assert.ok(drawn > 40, `${drawn} graphics`);
});

browserTest(
  "German has its words and its comma",
  { settings: { language: "de" } },
  async ({ page, open, stands, job, iteration, call }) => {
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
    await stands();
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
    await page.getByText("The dashboard has been renewed on the server.").waitFor();
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
    // as any style of a page might ask for it
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
