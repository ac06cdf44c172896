// Every graphic of every page has a name, a sentence that says what is to be seen, and the same as a table.

import assert from "node:assert/strict";
import { browserTest, example } from "./harness.js";
import { pageList } from "./pages.js";

/** @typedef {import("playwright-core").Page} Page */

/** What holds a graphic with the button of its table. */
const HOLDERS = "figure, .flank-view, .lambda-map, .measure-preview, .all-teeth";

/** What is wrong with the graphics of a page, and how many there are. @param {Page} page */
function looked(page) {
  return page.evaluate((holders) => {
    const text = (/** @type {string | null} */ ids) =>
      (ids ?? "")
        .split(" ")
        .map((id) => document.getElementById(id)?.textContent?.trim() ?? "")
        .join(" ")
        .trim();
    /** @type {string[]} */
    const faults = [];
    const drawn = [...document.querySelectorAll("main svg, main canvas")].filter((one) => one.checkVisibility());
    // signs beside words say nothing of their own; a canvas and its overlay are one graphic
    const graphics = new Set(
      drawn.flatMap((one) => {
        const reader = one.closest(".chart-reader, [role=slider], [role=application]");
        if (reader) return [reader];
        if (one.getAttribute("aria-hidden") === "true") return [];
        return [one];
      }),
    );
    for (const one of graphics) {
      const told = `${one.tagName}.${one.getAttribute("class")}`;
      const name = one.getAttribute("aria-label") ?? text(one.getAttribute("aria-labelledby"));
      if (!name) faults.push(`${told} has no name`);
      if (one instanceof SVGElement && one.getAttribute("role") !== "img") faults.push(`${told} ${name} has no role`);
      // signs in tables: their values stand in the row, and in its file
      if (one.closest("td, th")) continue;
      // of a picture the sentence stands behind its name
      const said = text(one.getAttribute("aria-describedby")) || (name.split(". ")[1] ?? "");
      if (!said) faults.push(`${told} ${name} says nothing`);
      const holder = one.closest(holders);
      // the small map of a tooth is in the table of all of them, and large below
      const teeth = one.closest(".tooth-map") && holder?.closest(".all-teeth")?.querySelector("table");
      const button = [...(holder?.querySelectorAll("button") ?? [])].find(
        (of) => of.textContent?.trim() === "As table",
      );
      if (!teeth && !button) faults.push(`${told} ${name} has no table`);
    }
    return { faults, count: graphics.size };
  }, HOLDERS);
}

/** Presses each «as table» of a page at once, and waits until each has a table with rows. @param {Page} page */
async function asTables(page) {
  for (let guard = 0; guard < 5; guard += 1) {
    const pressed = await page.evaluate((holders) => {
      const left = [...document.querySelectorAll("main button")].filter(
        (one) => one.textContent?.trim() === "As table" && one.getAttribute("aria-pressed") !== "true",
      );
      for (const one of left) {
        one.closest(holders)?.setAttribute("data-looked", "");
        if (one instanceof HTMLElement) one.click();
      }
      return left.length;
    }, HOLDERS);
    await page.locator("[data-looked]:not(:has(tbody tr))").first().waitFor({ state: "detached" });
    if (pressed === 0) return;
  }
  assert.fail("there is no end of graphics");
}

browserTest("every graphic has a name, a summary and a table", {}, async (world) => {
  const { page, open, stands, job, call } = world;
  const listed = (await pageList(world)).filter((one) => !one.open && !one.name.startsWith("report"));
  const robust = JSON.parse(await example("flank_z52.json"));
  const { id } = await job({ name: "robust" });
  await call("POST", `/v1/jobs/${id}/iterations`, { ...robust, estimator: { type: "m_estimator", loss: "huber" } });
  const places = [
    ...listed,
    { name: "in space", path: `/jobs/${id}/iterations/1?space=1` },
    { name: "weights", path: `/jobs/${id}/iterations/1/statistics` },
  ];
  let all = 0;
  const look = async (/** @type {string} */ name) => {
    const { faults, count } = await looked(page);
    assert.deepEqual(faults, [], name);
    all += count;
    await asTables(page);
  };
  for (const { name, path } of places) {
    await open(path);
    await look(name);
  }
  const file = { name: "flank.json", mimeType: "application/json", buffer: Buffer.from(JSON.stringify(robust)) };
  await open(`/jobs/${id}/measure`);
  await page.setInputFiles("#measure-files", file);
  await page.locator(".queue-entry canvas").waitFor();
  await look("preview");
  await open("/fit");
  await page.getByLabel("Drop a file here").setInputFiles(file);
  await page.getByRole("heading", { name: "Figures of this fit" }).waitFor();
  await stands();
  await look("fit");
  assert.ok(all > 40, `${all} graphics`);
});

browserTest("the table of a map has its nodes, the first of many, and its file all", {}, async (world) => {
  const { page, open, job, call } = world;
  const { id } = await job();
  const [u, v] = [60, 50].map((count) => Array.from({ length: count }, (_, i) => 1 + i / 10));
  const z = u?.map((a) => v?.map((b) => Number((Math.sin(a) + 0.1 * b).toFixed(4))));
  await call("POST", `/v1/jobs/${id}/iterations`, {
    nodes: { type: "grid", u, v, z },
    model: { type: "polynomial", degree: 2 },
  });
  await open(`/jobs/${id}/iterations/1`);
  const view = page.locator(".flank-view");
  await view.getByRole("button", { name: "As table", exact: true }).first().click();
  const rows = page.locator(".flank-map tbody tr");
  await rows.first().waitFor();
  assert.equal(await rows.count(), 2000);
  await page.getByText("The first 2,000 of 3,000 nodes; the file has all.").waitFor();
  const cells = await rows.nth(51).locator(".cell").allTextContents();
  const [at, along, height = Number.NaN] = cells.map((text) => Number(text.replace("−", "-")));
  assert.deepEqual([at, along], [1.1, 1.1]);
  assert.ok(Math.abs(height - (z?.[1]?.[1] ?? Number.NaN)) < 1e-3, `${height}`);
  const begun = page.waitForEvent("download");
  await page.locator(".flank-map").getByRole("button", { name: "CSV" }).click();
  const stream = await (await begun).createReadStream();
  const text = Buffer.concat(await stream.toArray()).toString();
  assert.equal(text.trim().split(/\r?\n/).length, 3001);
  // the address shows it, so that it is shared and reloaded
  assert.match(page.url(), /table=1/);
});
