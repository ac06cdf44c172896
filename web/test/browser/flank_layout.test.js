// The layout of the page of a flank: names of its faces, space, and a map that is never blank.

import assert from "node:assert/strict";
import { browserTest, example } from "./harness.js";

const GERMAN = { settings: { language: "de" } };

browserTest("the ends of the face width are named as those of a cylindrical gear", GERMAN, async (world) => {
  const { page, open, job, iteration } = world;
  const { id } = await job();
  await iteration(id);
  await open(`/jobs/${id}/iterations/1`);
  const axes = page.locator(".flank-map .chart-axes text");
  const said = await axes.allTextContents();
  assert.ok(said.includes("Stirnseite I") && said.includes("Stirnseite II"), said.join(" | "));
  const text = (await page.locator("body").textContent()) ?? "";
  assert.doesNotMatch(text, /Zehe|Ferse/);
});

browserTest("next to the map no table is wider than its place", GERMAN, async ({ page, open, job, iteration }) => {
  const { id } = await job();
  await iteration(id);
  for (const width of [1280, 1180, 1024, 768]) {
    await page.setViewportSize({ width, height: 800 });
    await open(`/jobs/${id}/iterations/1`);
    const wider = await page
      .locator(".flank-page .table-scroll")
      .evaluateAll((boxes) => boxes.map((box) => [box.clientWidth, box.scrollWidth]));
    assert.equal(wider.length, 2);
    for (const [room = 0, needed = 0] of wider) assert.ok(needed <= room, `${width}: ${needed} in ${room}`);
  }
});

browserTest("on a tablet no table is cut off, and no name overlaps a value", GERMAN, async (world) => {
  const { page, open, job, iteration, call } = world;
  const { requirements } = JSON.parse(await example("requests/job_requirements.json"));
  const { id } = await job({ requirements });
  await iteration(id);
  const at = `/v1/jobs/${id}/iterations`;
  await call("POST", `${at}/1/evaluations`, await example("requests/gear_evaluate.json"));
  await call("POST", `${at}/1/correction`, JSON.parse(await example("requests/iteration_correction.json")));
  await iteration(id, "flank_z52_remachined.json");
  for (const width of [768, 1000]) {
    await page.setViewportSize({ width, height: 900 });
    for (const place of ["", "/iterations/1", "/iterations/1/evaluation", "/iterations/1/correction"]) {
      await open(`/jobs/${id}${place}`);
      const [wider, over] = await page.locator(".table-scroll").evaluateAll((boxes) => [
        boxes.flatMap((box) => (box.scrollWidth > box.clientWidth ? [`${box.scrollWidth} in ${box.clientWidth}`] : [])),
        boxes.flatMap((box) =>
          [...box.querySelectorAll("tbody :is(th, td):not(:has(.visually-hidden))")].flatMap((cell) => {
            const text = document.createRange();
            text.selectNodeContents(cell);
            const beyond = text.getBoundingClientRect().right - cell.getBoundingClientRect().right;
            return beyond > 1 ? [`${cell.textContent}: ${beyond} px`] : [];
          }),
        ),
      ]);
      assert.deepEqual(wider, [], `${width} ${place}`);
      assert.deepEqual(over, [], `${width} ${place}`);
    }
  }
});

for (const language of ["en", "de"]) {
  browserTest(
    `on a tablet the map begins in the upper part of the window, ${language}`,
    { settings: { language } },
    async (world) => {
      const { page, open, job, iteration } = world;
      const { requirements } = JSON.parse(await example("requests/job_requirements.json"));
      const { id } = await job({ requirements });
      await iteration(id);
      await iteration(id, "flank_z52_remachined.json");
      for (const { most, ...size } of [
        { width: 768, height: 1024, most: 400 },
        { width: 1000, height: 700, most: 360 },
      ]) {
        await page.setViewportSize(size);
        await open(`/jobs/${id}/iterations/1`);
        const { top, overlaps } = await page.evaluate(() => {
          const top = document.querySelector(".heat-map")?.getBoundingClientRect().top ?? Number.NaN;
          const controls = [...document.querySelectorAll("main :is(a, button, select, summary)")]
            .filter((one) => one.checkVisibility())
            .map((one) => ({ name: one.textContent, box: one.getBoundingClientRect() }))
            .filter(({ box }) => box.top < top);
          const overlaps = controls.flatMap(({ name, box }, i) =>
            controls.slice(i + 1).flatMap((other) => {
              const separate =
                box.right <= other.box.left + 1 ||
                other.box.right <= box.left + 1 ||
                box.bottom <= other.box.top + 1 ||
                other.box.bottom <= box.top + 1;
              return separate ? [] : [`${name} over ${other.name}`];
            }),
          );
          return { top, overlaps };
        });
        assert.ok(top <= most, `${size.width} px: the map begins at ${top} px`);
        assert.deepEqual(overlaps, [], `${size.width} px`);
        // all content above it is there
        for (const place of [
          ".figure-tiles",
          "[data-extreme=least]",
          "[data-extreme=greatest]",
          ".layer-choice select",
        ])
          await page.locator(place).waitFor();
        const menu = page.locator(".flank-tools .menu");
        await menu.locator("summary").click();
        await menu.getByRole("button").nth(6).waitFor();
        await menu.getByRole("button").nth(2).click();
        await page.waitForURL(/contours=1/);
        await menu.getByRole("button").first().waitFor({ state: "hidden" });
        const focused = () => menu.locator("summary").evaluate((summary) => summary === document.activeElement);
        assert.ok(await focused(), "the focus is on the button of the menu again");
        await page.keyboard.press("Enter");
        await menu.getByRole("button").first().waitFor();
        await page.keyboard.press("Shift+Tab");
        await menu.getByRole("button").first().waitFor({ state: "hidden" });
        await menu.locator("summary").click();
        await page.keyboard.press("Escape");
        await menu.getByRole("button").first().waitFor({ state: "hidden" });
        await menu.locator("summary").click();
        await page.locator("h1").click();
        await menu.getByRole("button").first().waitFor({ state: "hidden" });
      }
    },
  );
}

browserTest("a map is painted in the frame in which its width changes", {}, async ({ page, open, job, iteration }) => {
  const { id } = await job();
  await iteration(id);
  await open(`/jobs/${id}/iterations/1`);
  // an observer that came later is called after the page's own, and before the frame is shown
  await page.evaluate(() => {
    const box = /** @type {HTMLElement} */ (document.querySelector(".heat-map"));
    const canvas = /** @type {HTMLCanvasElement} */ (box.querySelector("canvas"));
    const copy = new OffscreenCanvas(1, 1).getContext("2d", { willReadFrequently: true });
    const frames = /** @type {number[][]} */ ([]);
    Object.assign(window, { frames });
    new ResizeObserver(() => {
      copy?.clearRect(0, 0, 1, 1);
      copy?.drawImage(canvas, 0, 0, canvas.width, canvas.height, 0, 0, 1, 1);
      frames.push([box.clientWidth, copy?.getImageData(0, 0, 1, 1).data[3] ?? 0]);
    }).observe(box);
  });
  for (const width of [1240, 1100, 900]) {
    await page.setViewportSize({ width, height: 800 });
    // the width at that time: adjacent panels may change it once more
    await page.waitForFunction((wide) => {
      const place = document.querySelector(".heat-map")?.clientWidth;
      return window.innerWidth === wide && /** @type {any} */ (window).frames.at(-1)?.[0] === place;
    }, width);
  }
  const frames = await page.evaluate(() => /** @type {any} */ (window).frames);
  assert.ok(frames.length >= 3, JSON.stringify(frames));
  for (const [, alpha] of frames) assert.equal(alpha, 255, JSON.stringify(frames));
});
