// What a first view may cost: 10 Mbit/s, 20 ms to the server and back.

import assert from "node:assert/strict";
import { browserTest, inBrowser } from "../browser/harness.js";
import { median, ROUNDS, slowness } from "./rounds.js";

const BYTES = 150_000;
const REQUESTS = 60;
const PAINT_MS = 1000;
const USABLE_MS = 1500;

/** @param {import("../browser/harness.js").World} world */
async function firstView({ page, server, stands }) {
  const network = await page.context().newCDPSession(page);
  await network.send("Network.enable");
  const speed = 10e6 / 8;
  await network.send("Network.emulateNetworkConditions", {
    offline: false,
    latency: 20,
    downloadThroughput: speed,
    uploadThroughput: speed,
  });
  let bytes = 0;
  let requests = 0;
  network.on("Network.loadingFinished", ({ encodedDataLength }) => {
    bytes += encodedDataLength;
    requests += 1;
  });
  await page.addInitScript(() => {
    const usable = () => {
      if (!document.querySelector('main[aria-busy="false"] tbody tr')) return requestAnimationFrame(usable);
      performance.mark("usable");
      return 0;
    };
    usable();
  });
  await page.goto(`${server.url}/jobs`);
  await stands();
  const marks = await page.waitForFunction(() => {
    const at = (/** @type {string} */ name) => performance.getEntriesByName(name)[0]?.startTime;
    const [paint, usable] = [at("first-contentful-paint"), at("usable")];
    return paint !== undefined && usable !== undefined && { paint, usable };
  });
  const { paint, usable } = /** @type {{ paint: number, usable: number }} */ (await marks.jsonValue());
  return { paint, usable, bytes, requests };
}

browserTest("a first view is there soon", {}, async ({ page, server, job }) => {
  await job();
  /** @type {Awaited<ReturnType<typeof firstView>>[]} */
  const views = [];
  // a context of its own each time, so that nothing is cached
  for (let round = 0; round < ROUNDS; round += 1)
    await inBrowser(server, {}, async (world) => void views.push(await firstView(world)));
  const of = (/** @type {"paint" | "usable" | "bytes" | "requests"} */ what) => median(views.map((view) => view[what]));
  const [paint, usable, bytes, requests] = [of("paint"), of("usable"), of("bytes"), of("requests")];
  const measured = `paint ${paint.toFixed(0)} ms, usable ${usable.toFixed(0)} ms, ${bytes} bytes, ${requests} requests`;
  console.log(measured);
  assert.ok(bytes > 20_000 && bytes <= BYTES && requests <= REQUESTS, measured);
  const slower = await slowness(page);
  assert.ok(paint <= PAINT_MS * slower && usable <= USABLE_MS * slower, measured);
});
