// The time that a map of 100,000 nodes takes.

import assert from "node:assert/strict";
import { browserTest, inBrowser } from "../browser/harness.js";
import { median, ROUNDS } from "./rounds.js";

function nodes() {
  const [rows, columns] = [250, 400];
  const u = Array.from({ length: rows }, (_, i) => 6 + (5 * i) / rows);
  const v = Array.from({ length: columns }, (_, j) => 1 + (13 * j) / columns);
  const z = u.map((a) => v.map((b) => Number((4 * Math.sin(a) + 0.3 * b - 0.05 * b * b).toFixed(4))));
  return { type: "grid", u, v, z };
}

/** @param {import("../browser/harness.js").World} world @param {string} id */
async function drawing({ page, open }, id) {
  await open(`/jobs/${id}`);
  await page.evaluate(() => {
    const seen = /** @type {{ answered: number, drawn: number }} */ ({ answered: 0, drawn: 0 });
    Object.assign(window, { seen });
    new PerformanceObserver((list) => {
      for (const entry of list.getEntries()) {
        if (entry.name.endsWith("/nodes")) seen.answered = /** @type {PerformanceResourceTiming} */ (entry).responseEnd;
      }
    }).observe({ type: "resource" });
    new MutationObserver(() => {
      if (seen.drawn === 0 && document.querySelector('[data-extreme="greatest"]')) seen.drawn = performance.now();
    }).observe(document.body, { subtree: true, childList: true });
  });
  const browser = page.context().browser();
  assert.ok(browser);
  await browser.startTracing(page, { categories: ["toplevel", "__metadata"] });
  await page.getByRole("navigation", { name: "Views of this job" }).getByRole("link", { name: "Iteration 1" }).click();
  await page.locator('[data-extreme="greatest"]').waitFor();
  const seen = await page.evaluate(() => /** @type {any} */ (window).seen);
  assert.ok(seen.answered > 0 && seen.drawn > 0, JSON.stringify(seen));
  return { drawn: seen.drawn - seen.answered, task: longestTask(await browser.stopTracing()) };
}

/**
 * Returns the longest task of the page's main thread, in milliseconds of that thread: other load of
 * the machine does not count.
 * @param {Buffer} tracing
 */
function longestTask(tracing) {
  /** @type {{ name: string, pid: number, tid: number, tdur?: number, args: { name?: string } }[]} */
  const events = JSON.parse(tracing.toString()).traceEvents;
  const thread = (/** @type {{ pid: number, tid: number }} */ { pid, tid }) => `${pid} ${tid}`;
  const main = new Set(
    events.filter(({ name, args }) => name === "thread_name" && args.name === "CrRendererMain").map(thread),
  );
  const tasks = events.filter((event) => event.name.endsWith("RunTask") && main.has(thread(event)));
  assert.ok(tasks.length > 10, `${tasks.length} tasks in the trace`);
  return Math.max(...tasks.map(({ tdur = 0 }) => tdur / 1000));
}

browserTest("a map of 100,000 nodes", {}, async ({ server, job, call }) => {
  const { id } = await job();
  await call("POST", `/v1/jobs/${id}/iterations`, {
    nodes: nodes(),
    model: { type: "polynomial", degree: 2 },
  });
  /** @type {{ drawn: number, task: number }[]} */
  const maps = [];
  for (let round = 0; round < ROUNDS; round += 1)
    await inBrowser(server, {}, async (world) => void maps.push(await drawing(world, id)));
  const [drawn, task] = [median(maps.map((map) => map.drawn)), median(maps.map((map) => map.task))];
  console.log(`drawn after ${drawn.toFixed(0)} ms, longest task ${task.toFixed(0)} ms`);
});
