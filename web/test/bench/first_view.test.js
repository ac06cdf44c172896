// The time to a first view at 10 Mbit/s and a round trip of 20 ms.

import { browserTest, inBrowser } from "../browser/harness.js";
import { median, ROUNDS } from "./rounds.js";

/** @param {import("../browser/harness.js").World} world */
async function firstView({ page, server, loaded }) {
  const network = await page.context().newCDPSession(page);
  await network.send("Network.enable");
  const speed = 10e6 / 8;
  await network.send("Network.emulateNetworkConditions", {
    offline: false,
    latency: 20,
    downloadThroughput: speed,
    uploadThroughput: speed,
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
  await loaded();
  const marks = await page.waitForFunction(() => {
    const at = (/** @type {string} */ name) => performance.getEntriesByName(name)[0]?.startTime;
    const [paint, usable] = [at("first-contentful-paint"), at("usable")];
    return paint !== undefined && usable !== undefined && { paint, usable };
  });
  return /** @type {{ paint: number, usable: number }} */ (await marks.jsonValue());
}

browserTest("a first view", {}, async ({ server, job }) => {
  await job();
  /** @type {Awaited<ReturnType<typeof firstView>>[]} */
  const views = [];
  // a context of its own each time, so that nothing is cached
  for (let round = 0; round < ROUNDS; round += 1)
    await inBrowser(server, {}, async (world) => void views.push(await firstView(world)));
  const [paint, usable] = [median(views.map((view) => view.paint)), median(views.map((view) => view.usable))];
  console.log(`paint ${paint.toFixed(0)} ms, usable ${usable.toFixed(0)} ms`);
});
