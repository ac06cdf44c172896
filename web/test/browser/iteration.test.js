// The flank map: its names and numbers are those of the interface.

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { browserTest, example } from "./harness.js";

const map = (/** @type {string} */ id, /** @type {number} */ number, query = "") =>
  `/jobs/${id}/iterations/${number}${query}`;

/** @param {number} value */
const digits = (value) => value.toFixed(1).replace("-", "−");

browserTest("the map names the least and the greatest node", {}, async ({ page, open, job, iteration, call }) => {
  const { id } = await job();
  await iteration(id);
  await open(map(id, 1));
  const { z } = await call("GET", `/v1/jobs/${id}/iterations/1/nodes`);
  for (const [name, sign] of /** @type {const} */ ([
    ["least", -1],
    ["greatest", 1],
  ])) {
    const all = z.flatMap((/** @type {(number | null)[]} */ heights, /** @type {number} */ row) =>
      heights.flatMap((height, column) => (height === null ? [] : [{ z: height, row, column }])),
    );
    const best = all.reduce((/** @type {any} */ a, /** @type {any} */ b) => (sign * b.z > sign * a.z ? b : a));
    const text = (await page.locator(`[data-extreme="${name}"]`).textContent()) ?? "";
    assert.ok(text.includes(`row ${best.row + 1}, column ${best.column + 1}`), `${name}: ${text}`);
    assert.ok(text.includes(`${digits(best.z)} µm`), `${name}: ${text}`);
  }
  await page.getByText("3 nodes missing").waitFor();
});

browserTest("the address has layers, crosshair and zoom", {}, async ({ page, open, loaded, job, iteration, call }) => {
  const { id } = await job();
  await iteration(id);
  await iteration(id, "flank_z52_remachined.json");
  await open(map(id, 2));
  await page.getByLabel("Layer").selectOption({ label: "Residual" });
  await page.waitForURL(/layer=residual/);
  await loaded();
  const made = await call("GET", `/v1/jobs/${id}/iterations/2`);
  const fit = made.fits.find((/** @type {{ chosen: boolean }} */ one) => one.chosen);
  const { result } = await call("GET", `/v1/jobs/${id}/iterations/2/fits/${fit.id}?include=residuals,fitted`);
  const greatest = Math.max(...result.residuals.values);
  await page.locator('[data-extreme="greatest"]', { hasText: digits(greatest) }).waitFor();
  await page.getByLabel("Layer").selectOption({ label: "Fitted" });
  const top = Math.max(...result.residuals.fitted);
  await page.locator('[data-extreme="greatest"]', { hasText: digits(top) }).waitFor();
  await page.getByLabel("Layer").selectOption({ label: "Difference from another iteration" });
  const [first, second] = await Promise.all([1, 2].map((n) => call("GET", `/v1/jobs/${id}/iterations/${n}/nodes`)));
  const differences = second.z.flatMap((/** @type {(number | null)[]} */ row, /** @type {number} */ i) =>
    row.flatMap((z, j) => (z === null || first.z[i][j] === null ? [] : [z - first.z[i][j]])),
  );
  const most = Math.max(...differences);
  await page.locator('[data-extreme="greatest"]', { hasText: digits(most) }).waitFor();
  const slider = page.getByRole("slider", { name: /minus iteration 1/ });
  await slider.focus();
  await page.keyboard.press("ArrowRight");
  await page.keyboard.press("ArrowUp");
  await page.waitForURL(/at=/);
  const said = await slider.getAttribute("aria-valuetext");
  await page.getByRole("button", { name: "Zoom in" }).click();
  await page.waitForURL(/zoom=/);
  await page.reload();
  await loaded();
  assert.equal(await page.getByRole("slider", { name: /minus iteration 1/ }).getAttribute("aria-valuetext"), said);
  await page.getByRole("button", { name: "Whole flank" }).click();
  await page.waitForURL((url) => !url.search.includes("zoom"));
});

browserTest("a map from the design", {}, async ({ page, open, loaded, job, iteration, call }) => {
  const { id } = await job({ requirements: { design: { profile_crowning_um: 8, helix_crowning_um: 5 } } });
  await iteration(id);
  await open(map(id, 1));
  await page.getByLabel("Layer").selectOption({ label: "Measured, relative to the design" });
  await page.waitForURL(/layer=from_design/);
  await loaded();
  const [{ z }, { deviation_um: design }] = await Promise.all(
    ["nodes", "design"].map((what) => call("GET", `/v1/jobs/${id}/iterations/1/${what}`)),
  );
  const columns = z[0].length;
  const left = z.flatMap((/** @type {(number | null)[]} */ row, /** @type {number} */ i) =>
    row.flatMap((height, k) => (height === null ? [] : [height - design[i * columns + k]])),
  );
  await page.locator('[data-extreme="greatest"]', { hasText: digits(Math.max(...left)) }).waitFor();
  await page.locator('[data-extreme="least"]', { hasText: digits(Math.min(...left)) }).waitFor();
  // without a design there is no such layer
  const plain = await job();
  await iteration(plain.id);
  await open(map(plain.id, 1));
  assert.equal(await page.getByLabel("Layer").locator("option", { hasText: "design" }).count(), 0);
});

browserTest("a layer is saved as CSV and as PNG", {}, async ({ page, open, job, iteration, call }) => {
  const { id } = await job();
  await iteration(id);
  await open(map(id, 1));
  const tools = page.locator(".flank-tools");
  let waiting = page.waitForEvent("download");
  await tools.getByRole("button", { name: "CSV" }).click();
  const text = await readFile(await (await waiting).path(), "utf8");
  const rows = text.trimEnd().split("\r\n");
  assert.equal(rows[0], "Roll length [mm],Face width [mm],Measured [µm]");
  const { u, v, z } = await call("GET", `/v1/jobs/${id}/iterations/1/nodes`);
  assert.equal(rows.length, 1 + u.length * v.length);
  assert.equal(rows[1], `${u[0]},${v[0]},`);
  assert.equal(rows[2], `${u[0]},${v[1]},${z[0][1]}`);
  // its columns and numbers are readable by a German spreadsheet
  await page.evaluate(() => localStorage.setItem("flankfit.settings", JSON.stringify({ language: "de" })));
  await open(map(id, 1));
  waiting = page.waitForEvent("download");
  await tools.getByRole("button", { name: "CSV" }).click();
  const german = (await readFile(await (await waiting).path(), "utf8")).split("\r\n");
  assert.equal(german[0], "\uFEFFWälzlänge [mm];Zahnbreite [mm];Gemessen [µm]");
  assert.equal(german[2], [u[0], v[1], z[0][1]].map((value) => String(value).replace(".", ",")).join(";"));
  waiting = page.waitForEvent("download");
  await tools.getByRole("button", { name: "PNG" }).click();
  const png = await readFile(await (await waiting).path());
  assert.equal(png.subarray(1, 4).toString(), "PNG");
});

browserTest(
  "the second of two deciders sees the current decision",
  { statuses: [412] },
  async ({ page, open, job, iteration, call }) => {
    const { id } = await job();
    await iteration(id);
    await open(map(id, 1));
    await page.getByRole("button", { name: "Accept" }).click();
    const dialog = page.getByRole("dialog");
    await dialog.getByLabel("Reason").fill("within the limits");
    await call("PATCH", `/v1/jobs/${id}/iterations/1`, { decision: "rejected", reason: "burnt" });
    await dialog.getByRole("button", { name: "Accept" }).click();
    await dialog.getByText("Changed by someone else in the meantime").waitFor();
    await dialog.getByText("rejected").waitFor();
    assert.equal(await dialog.getByLabel("Reason").inputValue(), "within the limits");
    await dialog.getByRole("button", { name: "Accept anyway" }).click();
    await page.getByText("Decided: accepted.").waitFor();
    assert.equal((await call("GET", `/v1/jobs/${id}/iterations/1`)).decision, "accepted");
    const { iterations } = await call("GET", `/v1/jobs/${id}/trace`);
    assert.equal(iterations[0].decisions.at(-1).reason, "within the limits");
  },
);

browserTest("a curve is a line", {}, async ({ page, open, job, call }) => {
  const { id } = await job();
  await call("POST", `/v1/jobs/${id}/iterations`, await example("requests/fit_curve.json"));
  await open(map(id, 1));
  await page.getByRole("slider", { name: "Curve" }).waitFor();
});

browserTest("in space the flank turns by keys, and is not one colour", {}, async ({ page, open, job, iteration }) => {
  const { id } = await job();
  await iteration(id);
  await open(map(id, 1));
  await page.getByRole("button", { name: "3-D" }).click();
  const space = page.getByRole("application");
  await page.locator('[data-ready="1"]').waitFor();
  const looks = () => space.screenshot();
  /**
   * Polls until a picture meets a condition.
   * @param {string} what @param {(picture: Buffer) => boolean} holds
   */
  const until = async (what, holds) => {
    const last = performance.now() + 60_000;
    for (;;) {
      const picture = await looks();
      if (holds(picture)) return picture;
      assert.ok(performance.now() < last, what);
    }
  };
  const before = await until("one colour is a small image", (picture) => picture.length > 8000);
  await page.getByText(/Deviations are magnified .* times/).waitFor();
  await space.focus();
  await page.keyboard.press("ArrowRight");
  await page.waitForURL(/camera=-25/);
  // the address is written before the picture is drawn
  await until("it has not turned", (picture) => !picture.equals(before));
  await page.keyboard.press("3");
  await page.waitForURL(/camera=0%2C89/);
  await page.keyboard.press("0");
  await page.waitForURL(/camera=-30/);
});

browserTest(
  "a click in space reads out the node there, as in the map",
  {},
  async ({ page, open, loaded, job, iteration }) => {
    const { id } = await job();
    await iteration(id);
    await open(map(id, 1, "?space=1&camera=0,89,1"));
    await page.locator('[data-ready="1"]').waitFor();
    await page.getByRole("application").scrollIntoViewIfNeeded();
    const box = await page.getByRole("application").boundingBox();
    assert.ok(box);
    // from above the middle of the picture is that of the flank
    await page.mouse.click(box.x + box.width / 2, box.y + box.height / 2);
    await page.waitForURL(/at=/);
    await loaded();
    const at = new URL(page.url()).searchParams.get("at");
    const { nodes } = JSON.parse(await example("flank_z52.json"));
    const middle = (/** @type {number[]} */ all) => ((all[0] ?? 0) + (all.at(-1) ?? 0)) / 2;
    const near = (/** @type {number[]} */ all) =>
      all.reduce((best, one) => (Math.abs(one - middle(all)) < Math.abs(best - middle(all)) ? one : best));
    assert.equal(at, `${near(nodes.u)},${near(nodes.v)}`);
    const said = await page.locator(".flank-3d .picked").textContent();
    assert.ok(said?.includes("µm"), said ?? "");
    await page.locator(".flank-3d .chart-crosshair circle").waitFor();
    // the same node in the map
    await page.getByRole("button", { name: "3-D" }).click();
    await page.waitForURL((url) => !url.searchParams.has("space"));
    assert.equal(await page.locator(".chart-readout").first().textContent(), said);
  },
);

browserTest("without WebGL the map is shown, and a note", {}, async ({ page, open, job, iteration }) => {
  const { id } = await job();
  await iteration(id);
  await page.addInitScript(() => {
    const own = HTMLCanvasElement.prototype.getContext;
    HTMLCanvasElement.prototype.getContext = /** @type {any} */ (
      /** @this {HTMLCanvasElement} @param {string} kind @param {any[]} rest */
      function (kind, ...rest) {
        return kind.startsWith("webgl") ? null : Reflect.apply(own, this, [kind, ...rest]);
      }
    );
  });
  await open(map(id, 1, "?space=1"));
  await page.getByText("does not support 3-D graphics").waitFor();
  await page.getByRole("slider", { name: /Iteration 1: Measured/ }).waitFor();
});
