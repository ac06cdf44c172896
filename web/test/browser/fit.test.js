// Fits of dropped and pasted nodes: as the interface returns them, and nothing stored.

import assert from "node:assert/strict";
import path from "node:path";
import { fileURLToPath } from "node:url";
import { browserTest, example } from "./harness.js";

const flank = fileURLToPath(new URL("../../../examples/flank_z52.json", import.meta.url));

/** @param {number} value @param {number} digits */
const written = (value, digits) => {
  const [mantissa = "", power = "0"] = value.toExponential(digits - 1).split("e");
  const raised = [...power.replace("+", "").replace("-", "⁻")].map((one) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[Number(one)] ?? one).join("");
  if (Number(power) < -3 || Number(power) > Math.max(3, digits)) return `${mantissa}·10${raised}`.replace(/^-/, "−");
  return Number(`${mantissa}e${power}`)
    .toFixed(Math.max(0, digits - 1 - Number(power)))
    .replace("-", "−");
};

/** @param {import("playwright-core").Page} page @param {string} name @param {string} text @param {string} type */
async function drop(page, name, text, type) {
  const dataTransfer = await page.evaluateHandle(
    ({ name, text, type }) => {
      const transfer = new DataTransfer();
      transfer.items.add(new File([text], name, { type }));
      return transfer;
    },
    { name, text, type },
  );
  await page.dispatchEvent(".drop", "drop", { dataTransfer });
}

/** Returns the value of a name. @param {import("playwright-core").Page} page @param {string} name */
const fact = async (page, name) =>
  (
    await page
      .locator(".facts > div", { has: page.locator("dt", { hasText: new RegExp(`^${name}$`) }) })
      .locator("dd")
      .first()
      .textContent()
  )?.trim();

browserTest("a dropped flank is fitted and nothing is stored", {}, async ({ page, open, loaded, job, call }) => {
  const { id } = await job();
  await open("/fit");
  await page.getByText("Drop a file with nodes").waitFor();
  const text = await example("flank_z52.json");
  await drop(page, "flank_z52.json", text, "application/json");
  await page.getByRole("heading", { name: "Figures of this fit" }).waitFor();
  await loaded();
  const request = JSON.parse(text);
  for (const name of ["measured_at", "instrument", "operator", "note"]) delete request[name];
  const result = await call("POST", "/v1/fits", { ...request, include: ["residuals", "fitted", "intervals"] });
  assert.equal(await fact(page, "Nodes"), "135");
  assert.equal(await fact(page, "Missing"), "3");
  assert.equal(await fact(page, "Counted"), String(result.residuals.count));
  assert.equal(await fact(page, "Degrees of freedom"), String(result.residuals.degrees_of_freedom));
  assert.equal(await fact(page, "Condition"), written(result.spectrum.condition, 2));
  assert.equal(await fact(page, "RMS of the residuals"), `${written(result.residuals.rms, 3)} µm`);
  const rows = page.getByRole("region", { name: "Coefficients" }).locator("tbody tr");
  assert.equal(await rows.count(), result.coefficients.length);
  const [first] = result.coefficients;
  const place = Math.max(0, 1 - Math.floor(Math.log10(first.std_error)));
  const words = (await rows.first().textContent()) ?? "";
  assert.ok(words.includes(first.value.toFixed(place).replace("-", "−")), `${words}: ${first.value}`);
  await page.getByRole("columnheader", { name: "95 % interval" }).waitFor();
  await page.getByLabel("Layer").selectOption({ label: "Residual" });
  const greatest = Math.max(...result.residuals.values);
  await page.locator('[data-extreme="greatest"]', { hasText: `${greatest.toFixed(1)} µm` }).waitFor();
  for (const { code } of result.warnings)
    assert.equal(await page.getByText(code, { exact: true }).count(), code === "norm_limit_is_estimate" ? 0 : 1, code);
  assert.deepEqual((await call("GET", `/v1/jobs/${id}/trace`)).iterations, []);
});

browserTest("another model and criterion refit, and are in the address", {}, async ({ page, open, loaded, call }) => {
  await open("/fit");
  await page.getByLabel("Drop a file here").setInputFiles(flank);
  await page.getByRole("heading", { name: "Figures of this fit" }).waitFor();
  await page.getByLabel("λ* by").selectOption("gcv");
  await page.getByLabel("Polynomial").selectOption("3");
  await page.waitForURL(/by=gcv.*degree=3|degree=3.*by=gcv/);
  await page.locator(".facts dd", { hasText: /^gcv$/ }).waitFor();
  await page.locator(".facts dd", { hasText: /^16$/ }).waitFor();
  await loaded();
  const { nodes, axes, regularization } = JSON.parse(await example("flank_z52.json"));
  const result = await call("POST", "/v1/fits", {
    nodes,
    axes,
    model: { type: "polynomial", degree: [3, 3], basis: "legendre" },
    regularization: { ...regularization, lambda_star: { criterion: "gcv" } },
  });
  assert.equal(await fact(page, "RMS of the residuals"), `${written(result.residuals.rms, 3)} µm`);
});

browserTest(
  "pasted CSV: a missing height, and a cell that is no number",
  { statuses: [422] },
  async ({ page, open, loaded }) => {
    await open("/fit");
    await page.getByText("Paste nodes").click();
    const field = page.getByLabel("Nodes as JSON or as a table");
    const send = page.getByRole("button", { name: "Fit", exact: true });
    await field.fill("part;price\nbolt;cheap");
    await send.click();
    await page.getByText("no line of the table has two numbers").waitFor();
    const lines = ["u,v,z,weight"];
    for (let u = 0; u < 5; u += 1)
      for (let v = 0; v < 5; v += 1)
        lines.push(`${u},${v},${u === 2 && v === 2 ? "" : (u * u - v + 0.1 * ((u * v) % 3)).toFixed(2)},1`);
    await field.fill([...lines.slice(0, 4), "9,9,abc,1", ...lines.slice(4)].join("\n"));
    await send.click();
    await page.getByText("line 5, column 3 (z)").waitFor();
    assert.equal((await page.getByRole("alert").textContent())?.split("line 5").length, 2, "the error is shown once");
    await field.fill(lines.join("\n"));
    await send.click();
    await page.getByRole("heading", { name: "Figures of this fit" }).waitFor();
    await loaded();
    assert.deepEqual(
      [await fact(page, "Nodes"), await fact(page, "Missing"), await fact(page, "Counted")],
      ["25", "1", "24"],
    );
    await page.getByLabel("Layer").selectOption({ label: "Residual" });
    await page.getByText("1 node missing").waitFor();
    await page.getByText("caller’s unit").first().waitFor();
    await field.fill("x,y\n0,1\n1,1.9\n2,3.1\n3,4\n4,5.2\n");
    await send.click();
    await page.getByRole("slider", { name: "Curve" }).waitFor();
  },
);

browserTest(
  "a refused file takes the result of the file before away",
  { statuses: [422] },
  async ({ page, open, loaded }) => {
    await open("/fit");
    await page.getByLabel("Drop a file here").setInputFiles(flank);
    await page.getByRole("heading", { name: "Figures of this fit" }).waitFor();
    await loaded();
    const refused = { name: "list.csv", mimeType: "text/csv", buffer: Buffer.from("part;price\nbolt;cheap\n") };
    await page.getByLabel("Drop a file here").setInputFiles(refused);
    await page.getByText("list.csv").waitFor();
    const gone = async () => {
      assert.equal(await page.getByRole("heading", { name: "Figures of this fit" }).count(), 0);
      assert.equal(await page.locator(".heat-map").count(), 0);
    };
    await gone();
    await page.reload();
    await loaded();
    await gone();
  },
);

browserTest("saved as an iteration of a job of the list", {}, async ({ page, open, loaded, job, call }) => {
  const { id } = await job({ name: "first of two" });
  await job({ name: "second of two" });
  await open("/fit");
  await page.getByLabel("Drop a file here").setInputFiles(flank);
  await page.getByRole("heading", { name: "Save as iteration" }).waitFor();
  await loaded();
  await page.getByLabel("Job", { exact: true }).selectOption(id);
  await page.getByLabel("Instrument").fill("P40");
  const sent = page.waitForRequest((request) => request.method() === "POST" && request.url().includes(id));
  await page.getByRole("button", { name: "Save", exact: true }).click();
  assert.ok((await sent).headers()["idempotency-key"]);
  await page.waitForURL(`**/jobs/${id}/iterations/1`);
  await page.getByText("Saved as iteration 1.").waitFor();
  const kept = await call("GET", `/v1/jobs/${id}/iterations/1`);
  assert.deepEqual([kept.node_count, kept.instrument, kept.flank], [135, "P40", "left"]);
  assert.equal(path.basename(flank), "flank_z52.json");
});

browserTest("the chosen job stays when flank and model change", {}, async ({ page, open, loaded, job }) => {
  const { id } = await job({ name: "chosen and kept" });
  await job({ name: "changed last" });
  await open("/fit");
  await page.getByLabel("Drop a file here").setInputFiles(flank);
  const chosen = page.getByLabel("Job", { exact: true });
  await chosen.selectOption(id);
  await page.getByLabel("Flank", { exact: true }).selectOption("right");
  await page.waitForURL(/flank=right/);
  await loaded();
  assert.equal(await chosen.inputValue(), id);
  await page.getByLabel("Find a job").fill("chosen and");
  await page.getByLabel("Polynomial").selectOption("3");
  await page.waitForURL(/degree=3/);
  await loaded();
  assert.equal(await chosen.inputValue(), id);
  assert.equal(await page.getByLabel("Find a job").inputValue(), "chosen and");
});

browserTest("a fit whose figures are not computed says so", {}, async ({ page, open, loaded }) => {
  const text = await example("flank_z52.json");
  const buffer = Buffer.from(JSON.stringify({ ...JSON.parse(text), exclude: [{ row: 1, column: 1 }] }));
  await open("/fit");
  await page.getByLabel("Drop a file here").setInputFiles({ name: "l.json", mimeType: "application/json", buffer });
  const measured = page.getByRole("region", { name: "Measured quantity" });
  await measured.getByText("require the flank, the axes").waitFor();
  await measured.getByLabel("Teeth z").fill("52");
  await measured.getByLabel("Normal module").fill("1");
  await measured.getByText("Slopes, crownings and twist are not shown").waitFor();
  assert.equal(await measured.getByText("require the flank, the axes").count(), 0);
  await loaded();
});

browserTest("without a job a new one is made, and the nodes are still there", { alone: true }, async (world) => {
  const { page, open, loaded, call } = world;
  await open("/fit");
  await page.getByLabel("Drop a file here").setInputFiles(flank);
  const save = page.getByRole("region", { name: "Save as iteration" });
  await save.getByRole("link", { name: "New job" }).click();
  await page.getByLabel("Name", { exact: true }).fill("made on the way");
  await page.getByLabel("With gear data").uncheck();
  await page.getByRole("button", { name: "Create the job" }).click();
  await page.waitForURL("**/fit");
  await page.getByRole("heading", { name: "Figures of this fit" }).waitFor();
  await loaded();
  await save.getByRole("button", { name: "Save", exact: true }).click();
  await page.getByText("Saved as iteration 1.").waitFor();
  const { items } = await call("GET", "/v1/jobs");
  assert.deepEqual(
    items.map((/** @type {any} */ one) => [one.name, one.iteration_count]),
    [["made on the way", 1]],
  );
});

browserTest(
  "flank, axes, unit and gear are chosen, and the figures of the flank are shown",
  {},
  async ({ page, open, loaded, job, call }) => {
    const gear = { teeth: 52, normal_module_mm: 1 };
    const { id } = await job({ name: "to hold the fit", gear });
    const { nodes } = JSON.parse(await example("flank_z52.json"));
    const lines = ["u;v;z"];
    for (const [i, u] of nodes.u.entries())
      for (const [j, v] of nodes.v.entries()) lines.push([u, v, nodes.z[i][j] ?? ""].join(";"));
    const file = { name: "links.csv", mimeType: "text/csv", buffer: Buffer.from(lines.join("\n")) };
    await open("/fit");
    await page.getByLabel("Drop a file here").setInputFiles(file);
    const measured = page.getByRole("region", { name: "Measured quantity" });
    await measured.waitFor();
    assert.equal(await measured.getByLabel("Flank").inputValue(), "left", "as the name of the file says");
    assert.equal(await page.getByRole("list", { name: "Slopes, crownings, twist" }).count(), 0);
    await measured.getByLabel("Teeth z").fill("52");
    await measured.getByLabel("Normal module").fill("1");
    // the gear says that u is a roll length
    await measured.getByText("Greatest deviation").waitFor();
    assert.deepEqual(
      [await measured.getByLabel("Axes of a table").inputValue(), await measured.getByLabel("Unit").inputValue()],
      ["roll_length", "um"],
    );
    const tiles = page.getByRole("list", { name: "Slopes, crownings, twist" });
    await tiles.waitFor();
    await loaded();
    const request = { gear, flank: "left", profile: nodes.u, z_mm: nodes.v, regularization: { type: "spectral" } };
    const figures = await call("POST", "/v1/gears/flank-surface", { ...request, deviation_um: nodes.z });
    const slope = figures.profile_slope_um;
    const place = Math.max(0, 1 - Math.floor(Math.log10(slope.std_error)));
    const words = (await tiles.getByRole("listitem").first().textContent()) ?? "";
    assert.ok(words.includes(slope.value.toFixed(place).replace("-", "−")), `${words}: ${slope.value}`);
    await page.getByRole("region", { name: "Slopes, crownings, twist", exact: true }).waitFor();
    // in millimetres every figure is a thousand times as great
    const refit = page.waitForRequest((request) => request.url().endsWith("/v1/fits"));
    await measured.getByLabel("Unit").selectOption("mm");
    assert.equal((await refit).postDataJSON().axes.z.unit, "mm");
    const great = nodes.z.map((/** @type {(number | null)[]} */ row) => row.map((z) => (z === null ? null : 1000 * z)));
    const { value } = (await call("POST", "/v1/gears/flank-surface", { ...request, deviation_um: great }))
      .profile_slope_um;
    assert.ok(Math.abs(value / slope.value - 1000) < 1, String(value));
    const first = tiles.getByRole("listitem").first();
    // to the second digit of its error, which is a thousand times as great, too
    const step = 10 ** (3 - place);
    await first.filter({ hasText: String(Math.round(value / step) * step).replace("-", "−") }).waitFor();
    await measured.getByLabel("Unit").selectOption("um");
    await first.filter({ hasText: slope.value.toFixed(place).replace("-", "−") }).waitFor();
    // they are those of the stored iteration, whose axes and flank are the chosen ones
    await page.getByLabel("Find a job").fill("to hold the fit");
    await page.getByLabel("Job", { exact: true }).selectOption(id);
    await page.getByRole("button", { name: "Save", exact: true }).click();
    await page.waitForURL(`**/jobs/${id}/iterations/1`);
    const kept = await call("GET", `/v1/jobs/${id}/iterations/1`);
    assert.deepEqual([kept.flank, kept.axes.u.quantity, kept.axes.z.unit], ["left", "roll_length", "um"]);
    assert.ok(Math.abs(kept.fits[0].figures.profile_slope_um.value - slope.value) < 1e-6 * Math.abs(slope.value));
    // on the other flank the helix slope has the other sign
    await page.goBack();
    await tiles.waitFor();
    await page.getByRole("region", { name: "Measured quantity" }).getByLabel("Flank").selectOption("right");
    await page.waitForURL(/flank=right/);
    await loaded();
    const helix = (await tiles.getByRole("listitem").nth(1).textContent()) ?? "";
    assert.ok(helix.includes("−") !== figures.helix_slope_um.value < 0, helix);
  },
);
