// The time from a move of the slider to the figures of its refit.

import assert from "node:assert/strict";
import { browserTest } from "../browser/harness.js";
import { median, ROUNDS } from "./rounds.js";

/** Rows and columns. */
const SIZES = /** @type {const} */ ([
  [25, 40],
  [250, 400],
]);

for (const [rows, columns] of SIZES) {
  browserTest(`the slider shows figures of ${rows * columns} nodes`, {}, async (world) => {
    const { page, open, loaded, job, call } = world;
    const { id } = await job();
    const u = Array.from({ length: rows }, (_, i) => 6 + (5 * i) / rows);
    const v = Array.from({ length: columns }, (_, j) => 1 + (13 * j) / columns);
    const z = u.map((a) => v.map((b) => Number((4 * Math.sin(a) + 0.3 * b - 0.05 * b * b).toFixed(4))));
    await call("POST", `/v1/jobs/${id}/iterations`, {
      nodes: { type: "grid", u, v, z },
      model: { type: "polynomial", degree: [2, 2] },
      regularization: { type: "spectral" },
    });
    await open(`/jobs/${id}/iterations/1/lambda`);
    const slider = page.getByRole("slider", { name: /manual/ });
    await slider.focus();
    await page.keyboard.press("ArrowRight");
    await page.waitForURL(/lambda=/);
    await loaded();
    await page.evaluate(() => {
      const seen = { moved: 0, shown: 0 };
      Object.assign(window, { seen });
      addEventListener("keydown", () => Object.assign(seen, { moved: performance.now(), shown: 0 }));
      const facts = document.querySelector(".lambda-shown .facts");
      new MutationObserver(() => {
        if (seen.moved > 0) seen.shown = performance.now();
      }).observe(/** @type {Element} */ (facts), { subtree: true, childList: true, characterData: true });
    });
    /** @type {number[]} */
    const times = [];
    for (let round = 0; round < ROUNDS; round += 1) {
      const before = page.url();
      await page.keyboard.press("ArrowRight");
      // the address follows once the result is shown
      await page.waitForURL((url) => url.href !== before);
      const { moved, shown } = await page.evaluate(() => /** @type {any} */ (window).seen);
      assert.ok(shown > moved, `${shown} after ${moved}`);
      times.push(shown - moved);
    }
    const took = median(times);
    console.log(
      `${rows * columns} nodes: figures after ${took.toFixed(0)} ms (${times.map((one) => one.toFixed(0)).join(", ")})`,
    );
  });
}
