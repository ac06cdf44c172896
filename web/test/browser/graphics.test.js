// The table of a graphic is complete: nightly/sweep.test.js looks for one at each.

import assert from "node:assert/strict";
import { browserTest } from "./harness.js";

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
  await page.getByText("The first 2,000 of 3,000 nodes; the file contains all.").waitFor();
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
