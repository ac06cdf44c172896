// Suspected nodes next to and on the map: excluded by a refit that becomes the chosen fit, and included again.

import assert from "node:assert/strict";
import { browserTest, example } from "./harness.js";

browserTest("a suspected node is named, marked, left out and taken back in", {}, async (world) => {
  const { page, open, job, call } = world;
  const { id } = await job();
  const body = JSON.parse(await example("flank_z52.json"));
  body.nodes.z[4][7] += 77;
  await call("POST", `/v1/jobs/${id}/iterations`, body);
  const at = `/v1/jobs/${id}/iterations/1`;
  await open(`/jobs/${id}/iterations/1`);
  const panel = page.getByRole("region", { name: "Suspected gross errors", exact: true });
  await panel.getByText("Node row 5, column 8").waitFor();
  assert.match((await panel.textContent()) ?? "", /off by \+?7[0-9]/);
  await page.locator('.map-mark.suspected[data-node="67"]').waitFor();

  await panel.getByRole("button", { name: "Exclude", exact: true }).click();
  await page.locator('.map-mark.excluded[data-node="67"]').waitFor();
  await page.getByRole("region", { name: "Excluded", exact: true }).getByText("Node row 5, column 8").waitFor();
  const { fits } = await call("GET", at);
  const chosen = fits.find((/** @type {{ chosen: boolean }} */ one) => one.chosen);
  const fit = await call("GET", `${at}/fits/${chosen.id}`);
  assert.deepEqual(fit.spec.exclude, [{ row: 4, column: 7 }]);
  assert.equal(fit.reason, "Excluded: Node row 5, column 8");
  assert.equal(await page.locator(".map-mark.suspected").count(), 0);

  // a node of the map is read out, with its action below
  const { u, v } = await call("GET", `${at}/nodes`);
  await open(`/jobs/${id}/iterations/1?at=${u[4]},${v[7]}`);
  await page.locator(".map-node").getByRole("button", { name: "Include again", exact: true }).click();
  await page.locator('.map-mark.suspected[data-node="67"]').waitFor();
  assert.equal(await page.locator(".map-mark.excluded").count(), 0);

  // accepting it needs a reason, and the dialog says why before anything is sent
  await page.getByRole("button", { name: "Accept", exact: true }).click();
  const dialog = page.getByRole("dialog");
  await dialog.getByText("Some nodes are suspected gross errors.").waitFor();
  assert.equal(
    await dialog.getByLabel("Reason").evaluate((field) => /** @type {HTMLTextAreaElement} */ (field).required),
    true,
  );
});
