// Files of testers and of gear programs, and errors of files.

import assert from "node:assert/strict";
import { mkdtemp, rm, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import path from "node:path";
import { browserTest, doNotSendAgain, example } from "./harness.js";
import { curvesFile, rexsModel, valuesFile } from "./tester_files.js";

const picker = "#measure-files";
/** The gear of the files of testers. */
const SPUR = {
  teeth: 52,
  normal_module_mm: 1,
  normal_pressure_angle_deg: 20,
  profile_shift_coefficient: 0.011,
  face_width_mm: 15,
  tip_diameter_mm: 54.0219,
  root_diameter_mm: 49.5219,
};

/** @param {string} name @param {string} text */
const file = (name, text) => ({ name, mimeType: "application/octet-stream", buffer: Buffer.from(text) });

browserTest("curves of a tester become an iteration with its charts", {}, async ({ page, open, loaded, job, call }) => {
  const { id } = await job({ gear: SPUR });
  await open(`/jobs/${id}/measure`);
  await page.setInputFiles(picker, file("1.mka", curvesFile()));
  await page.locator(".queue-entry", { hasText: "gear tester curves" }).waitFor();
  // the gear of the file is read before it is sent
  await page.locator(".queue-entry .gears", { hasText: "z 52" }).waitFor();
  // and its traces: of each as many samples as the file has
  const traces = page.locator(".queue-entry").getByRole("table", { name: "6 traces of 1 flank" });
  const listed = await traces
    .locator("tbody tr")
    .evaluateAll((rows) =>
      rows.map((row) => [...row.querySelectorAll(".cell")].map((cell) => cell.textContent?.replaceAll("\u202f", " "))),
    );
  assert.deepEqual(listed, [
    ["1f", "left", "helix", "Roll length 7.303 mm", "60", "0"],
    ["1", "left", "helix", "Roll length 8.742 mm", "60", "0"],
    ["1k", "left", "helix", "Roll length 10.263 mm", "60", "0"],
    ["1u", "left", "profile", "z 1.000 mm", "60", "0"],
    ["1", "left", "profile", "z 7.500 mm", "60", "0"],
    ["1o", "left", "profile", "z 14.000 mm", "60", "0"],
  ]);
  await page.getByRole("button", { name: "Store as iteration" }).click();
  await page.waitForURL(`**/jobs/${id}/iterations/1`);
  await loaded();
  await page.getByRole("link", { name: "Evaluation" }).click();
  await page.waitForURL("**/evaluation");
  await loaded();
  const { items } = await call("GET", `/v1/jobs/${id}/iterations/1/records`);
  const record = await call("GET", `/v1/jobs/${id}/iterations/1/records/${items[0].id}`);
  const profiles = record.result.traces.filter((/** @type {any} */ trace) => trace.kind === "profile");
  assert.equal(profiles.length, 3);
  const rows = page.getByRole("region", { name: "Profiles" }).locator("tbody tr");
  for (const { slope_um: slope } of profiles) {
    assert.ok(Math.abs(slope - 10) < 0.01, `${slope}`);
    await rows.filter({ hasText: "10.0" }).first().waitFor();
  }
  // each trace of the file has its chart
  for (const kind of ["Profiles", "Helices"])
    assert.equal(await page.getByRole("img", { name: new RegExp(`^${kind}, Tooth 1`) }).count(), 3, kind);
});

browserTest("of a REXS model the gear is named, and its topography is a map", { statuses: [422] }, async (world) => {
  const { page, open, loaded, job, call } = world;
  const { id } = await job({ gear: SPUR });
  await open(`/jobs/${id}/measure`);
  await page.setInputFiles(picker, file("m.rexs", rexsModel()));
  await page.locator(".queue-entry .gears", { hasText: "wheel" }).waitFor();
  await page.getByRole("button", { name: "Store as iteration" }).click();
  // the field requires a choice of the two gears
  const component = page.getByLabel("Component");
  await page.locator('[aria-invalid="true"]').waitFor();
  assert.equal(await component.getAttribute("aria-invalid"), "true");
  await component.fill("7");
  await page.getByRole("button", { name: "Store as iteration" }).click();
  await page.waitForURL(`**/jobs/${id}/iterations/1`);
  await loaded();
  await page.locator('[data-extreme="greatest"]', { hasText: "26.0 µm" }).waitFor();
  assert.equal((await call("GET", `/v1/jobs/${id}/iterations/1`)).node_count, 16);
});

browserTest("points in space become a map of the deviations", {}, async (world) => {
  const { page, open, loaded, job, call, server } = world;
  const { id } = await job({ gear: SPUR });
  const flank = {
    gear: SPUR,
    flank: "left",
    profile: { axis: "diameter", values: [51, 51.5, 52, 52.5] },
    face_width_positions_mm: [2, 6, 10, 14],
  };
  const headers = { "content-type": "application/json", accept: "text/csv" };
  const response = await fetch(`${server.url}/v1/gears/flank`, {
    method: "POST",
    headers,
    body: JSON.stringify(flank),
  });
  assert.equal(response.status, 200);
  const [head, ...lines] = (await response.text()).trim().split(/\r?\n/);
  assert.equal(head, "id,x,y,z,i,j,k");
  // 5 µm along the normals, and 8 µm at one node
  const moved = lines.map((line, k) => {
    const [name, ...numbers] = line.split(",");
    const [x = 0, y = 0, z = 0, ...normal] = numbers.map(Number);
    return [name, ...[x, y, z].map((at, c) => at + (k === 5 ? 0.008 : 0.005) * (normal[c] ?? 0)), ...normal].join(",");
  });
  assert.equal(moved.length, 16);
  await open(`/jobs/${id}/measure`);
  await page.setInputFiles(picker, file("p.csv", [head, ...moved].join("\n")));
  await page.locator(".queue-entry", { hasText: "points in space" }).waitFor();
  await page.getByRole("button", { name: "Store as iteration" }).click();
  await page.waitForURL(`**/jobs/${id}/iterations/1`);
  await loaded();
  await page.locator('[data-extreme="greatest"]', { hasText: "8.0 µm" }).waitFor();
  await page.locator('[data-extreme="least"]', { hasText: "5.0 µm" }).waitFor();
  assert.equal((await call("GET", `/v1/jobs/${id}/iterations/1`)).node_count, 16);
});

browserTest("a file of values shows its gear, and is no measurement", {}, async ({ page, open, job }) => {
  const { id } = await job();
  await open(`/jobs/${id}/measure`);
  await page.setInputFiles(picker, file("1.mew", valuesFile()));
  const entry = page.locator(".queue-entry");
  await entry.getByText("only the gear and printed values").waitFor();
  await entry.locator(".gears", { hasText: "z 52" }).waitFor();
  const values = entry.getByRole("table", { name: "2 printed values" });
  const listed = await values
    .locator("tbody tr")
    .evaluateAll((rows) =>
      rows.map((row) => [...row.querySelectorAll(".cell")].map((cell) => cell.textContent?.replaceAll("\u202f", " "))),
    );
  assert.deepEqual(listed, [
    ["fHb links 1", "fHβ", "left", "Tooth 1", "−2.9 µm"],
    ["Fr", "Fr", "–", "gear", "30.1 µm"],
  ]);
  assert.ok(await page.getByRole("button", { name: "Store as iteration" }).isDisabled());
  assert.equal(await entry.getByRole("alert").count(), 0);
});

browserTest(
  "what is larger than the server takes is refused before it is sent",
  { serve: ["--body-limit=65536"] },
  async ({ page, open, job, call }) => {
    const { id } = await job();
    await open(`/jobs/${id}/measure`);
    const nodes = JSON.parse(await example("flank_z52.json"));
    nodes.note = "x".repeat(70_000);
    await page.setInputFiles(picker, file("large.json", JSON.stringify(nodes)));
    await page.locator(".queue-entry").getByText("The server accepts at most 66 kB").waitFor();
    assert.ok(await page.getByRole("button", { name: "Store as iteration" }).isDisabled());
    assert.deepEqual((await call("GET", `/v1/jobs/${id}/trace`)).iterations, []);
  },
);

browserTest("a table names the line and the column of a bad cell", { statuses: [422] }, async ({ page, open, job }) => {
  const { id } = await job();
  await open(`/jobs/${id}/measure`);
  const rows = [1, 2, 3, 4].flatMap((u) => [1, 2, 3, 4].map((v) => `${u},${v},${u === 2 && v === 3 ? "n/a" : u * v}`));
  await page.setInputFiles(picker, file("bad.csv", ["u,v,z", ...rows, ""].join("\n")));
  const entry = page.locator(".queue-entry");
  await entry.getByRole("alert").waitFor();
  assert.match(
    (await entry.getByRole("alert").textContent()) ?? "",
    /1 cell is not a finite number.*line 8, column 3/s,
  );
  assert.ok(await page.getByRole("button", { name: "Store as iteration" }).isDisabled());
});

browserTest("a file that was changed since it was read is not sent", {}, async ({ page, open, job, call }) => {
  const { id } = await job();
  await open(`/jobs/${id}/measure`);
  const folder = await mkdtemp(path.join(tmpdir(), "flankfit-file-"));
  const place = path.join(folder, "curve.csv");
  await writeFile(place, "u,v,z\n1,1,1\n1,2,2\n2,1,3\n2,2,5\n");
  await page.setInputFiles(picker, place);
  await page.locator(".queue-entry canvas").waitFor();
  await writeFile(place, "u,v,z\n1,1,1\n1,2,2\n2,1,3\n2,2,5\n3,1,9\n3,2,9\n");
  await page.getByRole("button", { name: "Store as iteration" }).click();
  await page.locator(".queue-entry").getByText("This file has changed since it was read.").waitFor();
  await page.locator(".queue-entry").getByText("changed", { exact: true }).waitFor();
  assert.deepEqual((await call("GET", `/v1/jobs/${id}/trace`)).iterations, []);
  await rm(folder, { recursive: true });
});

browserTest("the same file twice by one key is one iteration, over a reload too", { offline: true }, async (world) => {
  const { page, open, loaded, job, call } = world;
  const { id } = await job();
  await open(`/jobs/${id}/measure`);
  const flank = file("flank.json", await example("flank_z52.json"));
  await page.setInputFiles(picker, flank);
  await page.locator(".queue-entry canvas").waitFor();
  /** @type {(string | undefined)[]} */
  const keys = [];
  let reloaded = false;
  await page.route("**/v1/jobs/*/iterations", async (route) => {
    keys.push(route.request().headers()["idempotency-key"]);
    if (reloaded) return route.continue();
    await route.fetch();
    return route.abort("connectionreset");
  });
  await page.getByRole("button", { name: "Store as iteration" }).click();
  await doNotSendAgain(page);
  await page.locator(".queue-entry").getByText("The server is not responding").waitFor();
  reloaded = true;
  await page.reload();
  await loaded();
  await page.setInputFiles(picker, flank);
  await page.locator(".queue-entry canvas").waitFor();
  await page.getByRole("button", { name: "Store as iteration" }).click();
  await page.waitForURL(`**/jobs/${id}/iterations/1`);
  assert.ok(keys.length >= 2 && keys[0]);
  assert.equal(new Set(keys).size, 1);
  assert.equal((await call("GET", `/v1/jobs/${id}/trace`)).iterations.length, 1);
});

browserTest("what takes long shows how far it is, and ends when it is cancelled", { alone: true }, async (world) => {
  const { page, open, job, call } = world;
  const { id } = await job();
  await open(`/jobs/${id}/measure`);
  // a robust fit of many nodes begins from many starts
  const u = Array.from({ length: 150 }, (_, i) => 1 + i / 10);
  const v = Array.from({ length: 120 }, (_, i) => 1 + i / 10);
  const z = u.map((a) => v.map((b) => Number((Math.sin(a) + 0.1 * b * b + Math.sin(50 * a * b)).toFixed(4))));
  const request = {
    nodes: { type: "grid", u, v, z },
    model: { type: "polynomial", degree: [8, 8] },
    estimator: { type: "least_trimmed_squares" },
  };
  await page.setInputFiles(picker, file("long.json", JSON.stringify(request)));
  await page.locator(".queue-entry canvas").waitFor();
  await page.getByRole("button", { name: "Store as iteration" }).click();
  const entry = page.locator(".queue-entry");
  await entry.getByText(/^\d+\u202f%/).waitFor();
  await entry.getByRole("button", { name: "Cancel" }).click();
  await page.getByText("Cancelled. Data that had already arrived may be stored").waitFor();
  await entry.getByText("not sent yet").waitFor();
  assert.deepEqual((await call("GET", `/v1/jobs/${id}/trace`)).iterations, []);
});

browserTest("what is cut off before its result is sent again, and stored once", { offline: true }, async (world) => {
  const { page, open, job, call } = world;
  const { id } = await job();
  await open(`/jobs/${id}/measure`);
  await page.setInputFiles(picker, file("flank.json", await example("flank_z52.json")));
  await page.locator(".queue-entry canvas").waitFor();
  const met = ["before", "after"];
  await page.route("**/v1/jobs/*/iterations", async (route) => {
    const next = met.shift();
    if (next === undefined) return route.continue();
    // the response to a stored request is lost
    if (next === "after") await route.fetch();
    const body = 'event: progress\ndata: {"progress":0.5}\n\n';
    return route.fulfill({ contentType: "text/event-stream", body });
  });
  await page.getByRole("button", { name: "Store as iteration" }).click();
  await page.waitForURL(`**/jobs/${id}/iterations/1`);
  assert.deepEqual(met, []);
  assert.equal((await call("GET", `/v1/jobs/${id}/trace`)).iterations.length, 1);
});
