// What a first view may cost: 10 Mbit/s, 20 ms to the server and back.

import assert from "node:assert/strict";
import { browserTest } from "./harness.js";

const BYTES = 150_000;
const REQUESTS = 60;
const PAINT_MS = 1000;
const USABLE_MS = 1500;
/** By how much more a machine may take that others keep busy. */
const BUSY = 5;

browserTest("a first view is there soon", {}, async ({ page, server, stands, job }) => {
  await job();
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
  const { paint, usable } = await page.evaluate(() => ({
    paint: performance.getEntriesByName("first-contentful-paint")[0]?.startTime,
    usable: performance.getEntriesByName("usable")[0]?.startTime,
  }));
  const measured = `paint ${paint?.toFixed(0)} ms, usable ${usable?.toFixed(0)} ms, ${bytes} bytes, ${requests} requests`;
  console.log(measured);
  assert.ok(bytes > 20_000 && bytes <= BYTES && requests <= REQUESTS, measured);
  assert.ok(paint !== undefined && paint <= PAINT_MS * BUSY, measured);
  assert.ok(usable !== undefined && usable <= USABLE_MS * BUSY, measured);
});
