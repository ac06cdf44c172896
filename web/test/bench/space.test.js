// The time of a frame where 100,000 nodes turn in space, in software.

import assert from "node:assert/strict";
import { browserTest } from "../browser/harness.js";
import { median, ROUNDS } from "./rounds.js";

const [ROWS, COLUMNS] = [250, 400];
const FRAMES = 40;

browserTest("100,000 nodes turn", { context: { viewport: { width: 700, height: 800 } } }, async (world) => {
  const { page, open, job, call } = world;
  const { id } = await job();
  const u = Array.from({ length: ROWS }, (_, i) => 6 + (5 * i) / ROWS);
  const v = Array.from({ length: COLUMNS }, (_, j) => 1 + (13 * j) / COLUMNS);
  const z = u.map((a) => v.map((b) => Number((4 * Math.sin(a) + 0.3 * b - 0.05 * b * b).toFixed(4))));
  await call("POST", `/v1/jobs/${id}/iterations`, {
    nodes: { type: "grid", u, v, z },
    model: { type: "polynomial", degree: 2 },
  });
  await open(`/jobs/${id}/iterations/1?space=1`);
  const space = page.getByRole("application");
  await page.locator('[data-ready="1"]').waitFor();
  await space.scrollIntoViewIfNeeded();
  const box = await space.boundingBox();
  assert.ok(box);
  console.log(`drawn at ${box.width.toFixed(0)} × ${box.height.toFixed(0)}`);
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  await page.mouse.move(x, y);
  await page.mouse.down();
  // the first turn shows the coarser surface, which is brought to the card once
  await page.mouse.move(x + 3, y);
  const round = () =>
    page.evaluate(async (frames) => {
      const target = /** @type {Element} */ (document.querySelector('[role="application"]'));
      const rect = target.getBoundingClientRect();
      const at = (/** @type {number} */ i) => ({
        clientX: rect.x + rect.width / 2 + 4 * i,
        clientY: rect.y + rect.height / 2,
        bubbles: true,
        pointerId: 1,
      });
      const next = () => new Promise((resolve) => requestAnimationFrame(resolve));
      const canvas = /** @type {HTMLCanvasElement} */ (target.querySelector("canvas"));
      const gl = /** @type {WebGL2RenderingContext} */ (canvas.getContext("webgl2"));
      const pixel = new Uint8Array(4);
      const turn = async (/** @type {number} */ i) => {
        target.dispatchEvent(new PointerEvent("pointermove", at(i)));
        // waits until the frame is drawn, not only requested
        gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
        await next();
      };
      for (let i = 0; i < 5; i += 1) await turn(i);
      const times = [];
      for (let i = 0; i < frames; i += 1) {
        const from = performance.now();
        await turn(i + 5);
        times.push(performance.now() - from);
      }
      return times;
    }, FRAMES);
  // frames come at the rate of the screen, so the quietest of some rounds shows the time of a frame
  const medians = [];
  for (let i = 0; i < ROUNDS; i += 1) {
    medians.push(median(await round()));
  }
  await page.mouse.up();
  const frame = Math.min(...medians);
  console.log(`a frame takes ${frame.toFixed(1)} ms (${medians.map((one) => one.toFixed(1)).join(", ")})`);
});
