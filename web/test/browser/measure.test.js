// Measuring: a dropped file becomes an iteration, and errors are shown at their places.

import assert from "node:assert/strict";
import { axisOf, drawnIn, near } from "./drawn.js";
import { browserTest, example } from "./harness.js";

/** @param {string} name @param {string} text */
const file = (name, text) => ({ name, mimeType: "application/octet-stream", buffer: Buffer.from(text) });
const picker = "#measure-files";

browserTest(
  "a dropped file is seen, becomes an iteration, and its map is shown",
  {},
  async ({ page, open, job, call }) => {
    const { id } = await job();
    await open(`/jobs/${id}/measure`);
    const text = await example("flank_z52.json");
    const data = await page.evaluateHandle((content) => {
      const transfer = new DataTransfer();
      transfer.items.add(new File([content], "flank_z52.json"));
      return transfer;
    }, text);
    await page.dispatchEvent(".drop", "drop", { dataTransfer: data });
    await page.getByText("Preview of flank_z52.json").or(page.locator(".queue-entry canvas")).first().waitFor();
    await page.locator(".queue-entry", { hasText: "135" }).waitFor();
    await page.getByLabel("Operator").fill("A. B.");
    await page.getByRole("button", { name: "Store as iteration" }).click();
    await page.waitForURL(`**/jobs/${id}/iterations/1`);
    await page.locator('[data-extreme="least"]', { hasText: "row 1, column 15" }).waitFor();
    await page.locator('[data-extreme="greatest"]', { hasText: "row 8, column 7" }).waitFor();
    const made = await call("GET", `/v1/jobs/${id}/iterations/1`);
    assert.deepEqual([made.operator, made.node_count, made.tooth], ["A. B.", 135, "1"]);
  },
);

browserTest(
  "a bad cell is marked by row and column; what was typed stays, over a reload too",
  { statuses: [422] },
  async ({ page, open, loaded, job }) => {
    const { id } = await job();
    await open(`/jobs/${id}/measure`);
    const request = JSON.parse(await example("flank_z52.json"));
    const { u, v } = request.nodes;
    request.nodes.z[3][7] = "n/a";
    await page.getByLabel("Note").fill("after the </script> first cut");
    await page.setInputFiles(picker, file("bad.json", JSON.stringify(request)));
    await page.getByText("One cell is not a number:").waitFor();
    await page.getByRole("button", { name: "Store as iteration" }).click();
    await page.locator('[data-errors="nodes"]', { hasText: "row 4, column 8" }).waitFor();
    await loaded();
    // and on the map, where the axes have that node
    const map = page.locator(".measure-preview .heat-map");
    const cross = map.locator(".map-crosshair circle");
    const drawn = await drawnIn(map);
    near(Number(await cross.getAttribute("cx")), axisOf(drawn.x, "linear")(v[7]), "column 8");
    near(Number(await cross.getAttribute("cy")), axisOf(drawn.y, "linear")(u[3]), "row 4");
    assert.equal(await page.getByLabel("Note").inputValue(), "after the </script> first cut");
    await page.reload();
    await loaded();
    assert.equal(await page.getByLabel("Note").inputValue(), "after the </script> first cut");
  },
);

browserTest(
  "a table that is a grid is stored as one; several files become several iterations",
  {},
  async ({ page, open, job, call }) => {
    const { id } = await job();
    await open(`/jobs/${id}/measure`);
    const rows = [1, 2, 3, 4].flatMap((u) => [1, 2, 3, 4, 5].map((v) => `${u},${v},${u * u - v * (u % 2)}`));
    const csv = ["u,v,z", ...rows, ""].join("\n");
    const again = await example("flank_z52_remachined.json");
    await page.setInputFiles(picker, [file("table.csv", csv), file("second.json", again)]);
    await page.locator(".queue-entry", { hasText: "4 × 5" }).waitFor();
    await page.getByRole("button", { name: "Store 2 iterations" }).click();
    await page.getByRole("link", { name: "Iteration 2" }).first().waitFor();
    const stored = await call("GET", `/v1/jobs/${id}/iterations/1/nodes`);
    assert.deepEqual([stored.type, stored.u, stored.v, stored.z[0][0]], ["grid", [1, 2, 3, 4], [1, 2, 3, 4, 5], 0]);
    assert.equal((await call("GET", `/v1/jobs/${id}/iterations/2`)).node_count, 135);
  },
);

browserTest(
  "a German table is read with its units, which can be changed, and becomes an iteration",
  {},
  async ({ page, open, job, call }) => {
    const { id } = await job();
    await open(`/jobs/${id}/measure`);
    await page.setInputFiles(picker, file("links.csv", await example("files/flank_german.csv")));
    const entry = page.locator(".queue-entry");
    await entry.getByText("Semicolons, decimal commas, with a header").waitFor();
    const words = entry.locator("[data-preview=table]");
    await words.getByText("Greatest deviation 12.0 µm, roll length 5.97–11.5 mm, face width 0.750–14.3 mm.").waitFor();
    const unit = entry.getByLabel("Unit of Abweichung [µm]");
    await unit.selectOption("mm");
    await words.getByText(/^Greatest deviation 1\.20·10⁴ µm/).waitFor();
    await unit.selectOption("um");
    await words.getByText(/^Greatest deviation 12.0 µm/).waitFor();
    await page.getByRole("button", { name: "Store as iteration" }).click();
    await page.waitForURL(`**/jobs/${id}/iterations/1`);
    const stored = await call("GET", `/v1/jobs/${id}/iterations/1`);
    assert.deepEqual(
      [stored.flank, stored.axes.u.quantity, stored.axes.z.unit, stored.node_count],
      ["left", "roll_length", "um", 135],
    );
    assert.equal((await call("GET", `/v1/jobs/${id}/iterations/1/nodes`)).type, "grid");
    // the next table of this form is proposed by the same mapping
    await open(`/jobs/${id}/measure`);
    await page.setInputFiles(picker, file("links.csv", await example("files/flank_german.csv")));
    await entry.getByText("Taken from the last table of this format.").waitFor();
    await unit.selectOption("mm");
    await entry.locator("[data-remembered]").waitFor({ state: "detached" });
  },
);

browserTest("a lost answer is no second iteration", { offline: true }, async ({ page, open, job, call }) => {
  const { id } = await job();
  await open(`/jobs/${id}/measure`);
  await page.setInputFiles(picker, file("flank.json", await example("flank_z52.json")));
  await page.locator(".queue-entry canvas").waitFor();
  let lost = 0;
  await page.route("**/v1/jobs/*/iterations", async (route) => {
    if (route.request().method() === "POST" && lost === 0) {
      lost += 1;
      await route.fetch();
      return route.abort("connectionreset");
    }
    return route.continue();
  });
  await page.getByRole("button", { name: "Store as iteration" }).click();
  // the page itself sends it again
  await page.waitForURL(`**/jobs/${id}/iterations/1`);
  assert.equal(lost, 1);
  const { iterations } = await call("GET", `/v1/jobs/${id}/trace`);
  assert.equal(iterations.length, 1);
});

browserTest(
  "what is under way can be cancelled, and values only are no measurement",
  { statuses: [422] },
  async ({ page, open, job, call }) => {
    const { id } = await job();
    await open(`/jobs/${id}/measure`);
    await page.setInputFiles(picker, file("gear.mew", "no such file"));
    await page.getByText("only the gear and printed values").waitFor();
    assert.ok(await page.getByRole("button", { name: "Store as iteration" }).isDisabled());
    await page.getByRole("button", { name: "Remove" }).click();
    await page.getByText("Paste text instead").click();
    await page.getByLabel("JSON or a table").fill(await example("flank_z52.json"));
    await page.getByRole("button", { name: "Use this text" }).click();
    await page.locator(".queue-entry canvas").waitFor();
    await page.route("**/v1/jobs/*/iterations", () => {});
    await page.getByRole("button", { name: "Store as iteration" }).click();
    await page.locator(".queue-entry").getByRole("button", { name: "Cancel" }).click();
    await page.getByText("Cancelled.").waitFor();
    await page.locator(".queue-entry").getByText("not sent yet").waitFor();
    const { iterations } = await call("GET", `/v1/jobs/${id}/trace`);
    assert.equal(iterations.length, 0);
  },
);
