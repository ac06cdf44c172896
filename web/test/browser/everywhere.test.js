// What holds of every page: accessibility, languages, narrow screens, the keyboard.

import assert from "node:assert/strict";
import { browserTest } from "./harness.js";
import { pageList, visit } from "./pages.js";

/** What of axe's rules the colours of a theme decide. */
const OF_COLOURS = ["color-contrast", "link-in-text-block"];
/** Behind a number, whatever space parts them. */
const UNITS = /(?<=[\d⁰¹²³⁴-⁹]\s)[mµ]m(\/mm[²³⁴-⁹]?)?(?![\p{L}/])/gu;
const TABLET = { viewport: { width: 768, height: 1024 } };

browserTest(
  "axe finds nothing on any page, light and dark",
  { settings: { theme: "light" }, axe: true },
  async (world) => {
    const { page, accessible } = world;
    for (const listed of await pageList(world)) {
      await visit(world, listed);
      await accessible();
      // the themes differ in nothing else
      await page.evaluate(() => document.documentElement.setAttribute("data-theme", "dark"));
      await accessible(OF_COLOURS);
    }
  },
);

browserTest(
  "axe finds nothing on any page of a tablet",
  { settings: { theme: "light" }, context: TABLET, axe: true },
  async (world) => {
    for (const listed of await pageList(world)) {
      await visit(world, listed);
      await world.accessible();
    }
  },
);

for (const language of ["en", "de"]) {
  const context = { viewport: { width: 360, height: 740 } };
  browserTest(`nothing is wider than 360 px (${language})`, { context, settings: { language } }, async (world) => {
    for (const listed of await pageList(world)) {
      await visit(world, listed);
      const [scrollWidth = 0, clientWidth = 0] = await world.page.evaluate(() => {
        const { scrollWidth, clientWidth } = document.documentElement;
        return [scrollWidth, clientWidth];
      });
      assert.ok(scrollWidth <= clientWidth, `${listed.name}: ${scrollWidth} in ${clientWidth}`);
    }
  });
}

browserTest("every text is of the tables", { settings: { language: "pseudo" } }, async (world) => {
  for (const listed of await pageList(world)) {
    await visit(world, listed);
    const strays = await world.page.evaluate((units) => {
      // texts within texts are marked twice; units are the same in every language
      /** @type {(text: string) => string} */
      const bare = (text) => {
        const less = text.replaceAll(/⟦[^⟦⟧]*⟧/gu, "");
        return less === text ? less.replaceAll(units, "") : bare(less);
      };
      const marked = (/** @type {string} */ text) => !/\p{L}/u.test(bare(text));
      /** @type {string[]} */
      const found = [];
      const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
      for (let node = walker.nextNode(); node; node = walker.nextNode()) {
        const parent = node.parentElement;
        if (!parent || parent.closest("[translate=no], [lang], script, noscript, style")) {
          if (parent?.closest("[lang]") !== document.documentElement) continue;
        }
        if (parent?.closest("[translate=no], script, noscript, style")) continue;
        // an option holds text alone: the name by which the interface knows it stands in brackets
        const text = (node.textContent ?? "").replace(parent?.tagName === "OPTION" ? / \([a-z_]+\)$/ : "", "");
        if (!marked(text)) found.push(`${parent?.tagName}: ${node.textContent}`);
      }
      for (const one of document.querySelectorAll("[aria-label], [title], [placeholder], [aria-valuetext]")) {
        if (one.closest("[translate=no]")) continue;
        for (const name of ["aria-label", "title", "placeholder"]) {
          const text = one.getAttribute(name);
          if (text && !marked(text) && text !== "flankfit") found.push(`${one.tagName} ${name}: ${text}`);
        }
      }
      return found;
    }, UNITS);
    assert.deepEqual(strays, [], listed.name);
  }
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
    const rms = iterations[0].fits[0].rms.toFixed(1).replace(".", ",");
    assert.ok(((await page.locator("tbody").first().textContent()) ?? "").includes(rms), rms);
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
  assert.equal(await page.evaluate(() => document.activeElement?.textContent), "Skip to content");
  await page.keyboard.press("Enter");
  assert.equal(await page.evaluate(() => document.activeElement?.id), "content");
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
  assert.equal(await page.evaluate(() => document.activeElement?.textContent), "Edit", "the focus comes back");
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
