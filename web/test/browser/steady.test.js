// Nothing of a page jumps while it comes: what the browser counts as layout shifts stays small.

import assert from "node:assert/strict";
import { browserTest } from "./harness.js";
import { pageList } from "./pages.js";

/** Of the window, weighted by how far it moves; 0.1 is what is commonly called good. */
const MOST = 0.02;

/** @typedef {import("playwright-core").Page} Page */
/** @typedef {import("playwright-core").Route} Route */
/** @typedef {{ value: number, what: string[] }} Shift */

/** Waits until the browser has painted, and reported what it has. @param {Page} page */
const painted = (page) =>
  page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));

/**
 * Lets answers of the interface through one at a time, that asked for last first, each painted before the next one: so
 * they come on no machine, and on none worse.
 * @param {Page} page
 */
async function oneAtATime(page) {
  /** @type {Route[]} */
  const held = [];
  let letting = false;
  // the page may have gone on to the next one meanwhile, which wants nothing of what was asked for before
  const gone = () => undefined;
  const letThrough = async () => {
    letting = true;
    for (;;) {
      await painted(page).catch(gone);
      const route = held.pop();
      if (!route) break;
      await route.continue().catch(gone);
      const response = await route.request().response().catch(gone);
      await response?.finished().catch(gone);
    }
    letting = false;
  };
  await page.route(
    ({ pathname }) => pathname.startsWith("/v1/") && !pathname.endsWith("/events"),
    (route) => {
      // which shows all that it asks for, much of it, at once
      if (page.url().endsWith("/report")) return route.continue();
      held.push(route);
      return letting ? undefined : letThrough();
    },
  );
}

browserTest("nothing jumps while a page comes", {}, async (world) => {
  const { page, open } = world;
  const listed = (await pageList(world)).filter((one) => !one.open);
  await page.addInitScript(() => {
    /** @type {Shift[]} */
    const shifts = [];
    Object.assign(window, { shifts });
    new PerformanceObserver((list) => {
      for (const entry of /** @type {any[]} */ (list.getEntries())) {
        if (entry.hadRecentInput) continue;
        const what = entry.sources.map(
          (/** @type {any} */ { node }) => (node?.className || node?.id) ?? node?.textContent,
        );
        shifts.push({ value: entry.value, what });
      }
    }).observe({ type: "layout-shift", buffered: true });
  });
  await oneAtATime(page);
  /** @type {string[]} */
  const jumped = [];
  for (const { name, path } of listed) {
    await open(path);
    await painted(page);
    const shifts = await page.evaluate(() => /** @type {{ shifts: Shift[] }} */ (/** @type {any} */ (window)).shifts);
    const sum = shifts.reduce((all, { value }) => all + value, 0);
    const said = shifts.map(({ value, what }) => `${value.toFixed(3)} ${what}`);
    if (sum >= MOST) jumped.push(`${name}: ${sum.toFixed(3)} ${said.join("; ")}`);
  }
  assert.deepEqual(jumped, []);
});
