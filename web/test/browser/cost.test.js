// The cost of pages, counted; test/bench/ measures times.

import assert from "node:assert/strict";
import { browserTest, inBrowser } from "./harness.js";

/** The limit of compressed responses of the first view of the list. */
const MOST_BYTES = 150_000;
const MOST_REQUESTS = 60;
const MOST_DRAWS = 4;
const TURNS = 10;
const MOST_ROWS = 200;

browserTest("a first view takes few requests and bytes", {}, async ({ server, job }) => {
  await job();
  // a context of its own, so that nothing is cached
  await inBrowser(server, {}, async ({ page, loaded }) => {
    const network = await page.context().newCDPSession(page);
    await network.send("Network.enable");
    let bytes = 0;
    let requests = 0;
    network.on("Network.loadingFinished", ({ encodedDataLength }) => {
      bytes += encodedDataLength;
      requests += 1;
    });
    await page.goto(`${server.url}/jobs`);
    await page.locator('main[aria-busy="false"] tbody tr').first().waitFor();
    await loaded();
    const counted = `${bytes} bytes, ${requests} requests`;
    assert.ok(bytes > 20_000 && bytes <= MOST_BYTES && requests <= MOST_REQUESTS, counted);
  });
});

browserTest("a turn of 10,000 nodes uploads nothing to the graphics card", {}, async ({ page, open, job, call }) => {
  const { id } = await job();
  const u = Array.from({ length: 100 }, (_, i) => 6 + i / 20);
  const v = Array.from({ length: 100 }, (_, j) => 1 + j / 8);
  await call("POST", `/v1/jobs/${id}/iterations`, {
    nodes: { type: "grid", u, v, z: u.map((a) => v.map((b) => Math.sin(a) + 0.3 * b)) },
    model: { type: "polynomial", degree: 2 },
  });
  await page.addInitScript(() => {
    const counted = { draws: 0, uploads: 0 };
    Object.assign(window, { counted });
    const own = WebGL2RenderingContext.prototype;
    /** @param {(keyof WebGL2RenderingContext)[]} names @param {"draws" | "uploads"} key */
    const count = (names, key) => {
      for (const name of names) {
        const real = /** @type {Function} */ (own[name]);
        Object.assign(own, {
          [name]: /** @this {WebGL2RenderingContext} @param {unknown[]} all */ function (...all) {
            counted[key] += 1;
            return real.apply(this, all);
          },
        });
      }
    };
    count(["drawElements", "drawArrays"], "draws");
    count(["bufferData", "bufferSubData", "texImage2D"], "uploads");
  });
  await open(`/jobs/${id}/iterations/1?space=1`);
  const space = page.getByRole("application");
  await page.locator('[data-ready="1"]').waitFor();
  await space.scrollIntoViewIfNeeded();
  const box = await space.boundingBox();
  assert.ok(box);
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  await page.mouse.move(x, y);
  await page.mouse.down();
  // the first turn shows the coarser surface, which is uploaded once
  await page.mouse.move(x + 3, y);
  const { draws, uploads } = await page.evaluate(async (turns) => {
    const counted = /** @type {any} */ (window).counted;
    const target = /** @type {Element} */ (document.querySelector('[role="application"]'));
    const rect = target.getBoundingClientRect();
    const turn = (/** @type {number} */ i) => {
      const [clientX, clientY] = [rect.x + rect.width / 2 + 4 * i, rect.y + rect.height / 2];
      target.dispatchEvent(new PointerEvent("pointermove", { clientX, clientY, bubbles: true, pointerId: 1 }));
      return new Promise((resolve) => requestAnimationFrame(resolve));
    };
    for (let i = 0; i < 5; i += 1) await turn(i);
    Object.assign(counted, { draws: 0, uploads: 0 });
    for (let i = 0; i < turns; i += 1) await turn(i + 5);
    return counted;
  }, TURNS);
  await page.mouse.up();
  assert.equal(uploads, 0);
  assert.ok(draws > 0 && draws <= MOST_DRAWS * TURNS, `${draws} draws in ${TURNS} turns`);
});

browserTest("a list of 1,100 jobs is searched, filtered and paged", { alone: true }, async (world) => {
  const { page, open, loaded, iteration, call } = world;
  for (let i = 0; i < 1100; i += 1) {
    const name = `Gear ${String(i).padStart(5, "0")}`;
    await call("POST", "/v1/jobs", { name, serial_number: `S${i}`, machine: `grinder ${i % 10}` });
  }
  const { items } = await call("GET", "/v1/jobs?q=Gear+00411");
  await iteration(items[0].id);
  await open("/jobs");
  const counts = page.getByRole("navigation", { name: "Jobs by status" });
  await counts.getByRole("link", { name: "All 1,100" }).waitFor();
  await counts.getByRole("link", { name: "open 1" }).waitFor();
  await page.getByText("1–50 of 1,100").waitFor();
  // the job that was changed last comes first
  assert.equal(await page.locator("tbody th a").first().textContent(), "Gear 00411");
  await page.getByLabel("Search").fill("00312");
  await page.waitForURL((url) => url.search === "?q=00312");
  await page.getByRole("link", { name: "Gear 00411" }).waitFor({ state: "detached" });
  assert.deepEqual(await page.locator("tbody th a").allTextContents(), ["Gear 00312"]);
  await page.getByLabel("Search").fill("");
  await page.getByText("1–50 of 1,100").waitFor();
  assert.ok((await page.locator("tr").count()) <= MOST_ROWS);
  await page.getByLabel("Machine").selectOption("grinder 7");
  await page.getByText("1–50 of 110").waitFor();
  await page.getByLabel("Sort by").selectOption("name");
  await page.getByRole("link", { name: "Gear 00007" }).waitFor();
  await page.getByRole("link", { name: "Next page" }).click();
  await page.getByText("51–100 of 110").waitFor();
  await page.getByRole("link", { name: "Gear 00507" }).click();
  await page.getByRole("heading", { name: "Gear 00507" }).waitFor();
  await page.goBack();
  await page.getByText("51–100 of 110").waitFor();
  await page.getByRole("link", { name: "Gear 00507" }).waitFor();
  await page.goBack();
  await page.getByText("1–50 of 110").waitFor();
  await page.getByRole("link", { name: "Gear 00007" }).waitFor();
  await page.reload();
  await loaded();
  assert.equal(await page.locator("tbody th a").first().textContent(), "Gear 00007");
  // jobs of another status are not counted while a filter matches more than a page
  await counts.getByRole("link", { name: "open", exact: true }).click();
  await page.getByRole("link", { name: "Gear 00007" }).waitFor({ state: "detached" });
});
