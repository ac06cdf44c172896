// Nothing of a page jumps while it comes: what the browser counts as layout shifts stays small.

import assert from "node:assert/strict";
import { browserTest } from "./harness.js";
import { pageList } from "./pages.js";

/**
 * Of the window, weighted by how far it moves; 0.1 is what is commonly called good. All pages stay below 0.02 on a quiet
 * machine; on a busy one answers come in another order.
 */
const MOST = 0.05;

browserTest("nothing jumps while a page comes", {}, async (world) => {
  const { page, open } = world;
  const listed = (await pageList(world)).filter((one) => !one.open);
  // answers come one after another, as from a server that is not on the same machine
  const session = await page.context().newCDPSession(page);
  const slow = { offline: false, latency: 40, downloadThroughput: 1_250_000, uploadThroughput: 1_250_000 };
  await session.send("Network.emulateNetworkConditions", slow);
  await page.addInitScript(() => {
    /** @type {{ value: number, what: string[] }[]} */
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
  /** @type {string[]} */
  const jumped = [];
  for (const { name, path } of listed) {
    await open(path);
    // the browser reports what it has painted
    await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
    const shifts = await page.evaluate(
      () => /** @type {{ shifts: { value: number, what: string[] }[] }} */ (/** @type {any} */ (window)).shifts,
    );
    const sum = shifts.reduce((all, { value }) => all + value, 0);
    if (sum >= MOST)
      jumped.push(
        `${name}: ${sum.toFixed(3)} ${shifts.map(({ value, what }) => `${value.toFixed(3)} ${what}`).join("; ")}`,
      );
  }
  assert.deepEqual(jumped, []);
});
