// The pictures of docs/how-to/dashboard.md, of the job of `flankfit demo`: measured, corrected,
// machined again, accepted. Run by web/screenshots.

import assert from "node:assert/strict";
import { mkdir, rm, writeFile } from "node:fs/promises";
import path from "node:path";
import { after, test } from "node:test";
import { fileURLToPath } from "node:url";
import { example, inBrowser, serve } from "./browser/harness.js";
import { palettePng } from "./palette_png.js";

/** @typedef {import("./browser/harness.js").World} World */
/** @typedef {{ name: string, place: string, height?: number, ready?: string, at?: string, look?: "tablet" }} Picture */

const folder = fileURLToPath(new URL("../../docs/how-to/dashboard", import.meta.url));
const MOST_BYTES = 150_000;
const LOOKS = {
  desktop: { settings: { theme: "light" }, context: { viewport: { width: 1280, height: 800 } } },
  tablet: { settings: { theme: "dark" }, context: { viewport: { width: 768, height: 1024 } } },
};

/** The other jobs in the list of the demonstration. */
const OTHERS = [
  { name: "Planet gear, generating grinding", part_number: "41207", serial_number: "0112", machine: "RZ 260" },
  { name: "Sun gear, hobbed", part_number: "41201", serial_number: "0031", machine: "hobber 1" },
  { name: "Pump gear, finish grinding", part_number: "97340", serial_number: "0018", machine: "form grinder 3" },
  { name: "Pump gear, finish grinding", part_number: "97340", serial_number: "0019", machine: "form grinder 2" },
];

/** Decides on an iteration by its profile slope and the limits that apply. @param {World} world @param {string} at @param {string} decision */
async function decide({ call }, at, decision) {
  const { fits } = await call("GET", at);
  const { value, conformity } = fits.find((/** @type {any} */ fit) => fit.chosen).figures.profile_slope_um;
  const limits = conformity.limits_um.map((/** @type {number} */ limit) => limit.toFixed(1).replace("-", "−"));
  const reason = `profile slope ${value.toFixed(2)} µm, its limits are ${limits.join(" and ")} µm`;
  await call("PATCH", at, { decision, reason });
}

/** Returns the diameter at a roll length of the example's gear. @param {number} roll mm */
const diameter = (roll) => Number((2 * Math.hypot(26 * Math.cos(Math.PI / 9), roll)).toFixed(4));

/** Returns the traces through the middle of the nodes. @param {{ u: number[], v: number[], z: (number | null)[][] }} nodes */
async function evaluation({ u, v, z }) {
  const request = JSON.parse(await example("requests/gear_evaluate.json"));
  const [row, column] = [4, 7];
  const diameters = u.map(diameter);
  request.evaluation.profile_diameter_range_mm = [diameters[0], diameters.at(-1)];
  const of = { tooth: "1", flank: "left" };
  const profile = { kind: "profile", diameter_mm: diameters, deviation_um: z.map((line) => line[column]) };
  const helix = { kind: "helix", z_mm: v, deviation_um: z[row] };
  request.traces = [
    { ...of, ...profile, section_z_mm: v[column] },
    { ...of, ...helix, section_diameter_mm: diameters[row] },
  ];
  return request;
}

/** @param {World} world */
async function jobs(world) {
  const { call, job, iteration } = world;
  for (const [i, fields] of OTHERS.entries()) {
    const { id } = await job(fields);
    if (i === 1) continue;
    await iteration(id, i === 2 ? "flank_z52_remachined.json" : "flank_z52.json");
    const decision = ["remachine", "", "accepted"][i];
    if (decision)
      await call("PATCH", `/v1/jobs/${id}/iterations/1`, { decision, reason: "as the limits of class 6 say" });
  }
  const { nodes } = JSON.parse(await example("flank_z52.json"));
  const { requirements } = JSON.parse(await example("requests/job_requirements.json"));
  // a band over the whole measured range
  const band = (/** @type {[number, number][]} */ corners) => corners.map(([row, at]) => [diameter(nodes.u[row]), at]);
  Object.assign(requirements.k_bands[0], {
    upper: band([
      [2, 2],
      [7, 2],
      [8, 0],
    ]),
    lower: band([
      [2, -8],
      [5, -3],
      [8, -9],
    ]),
  });
  const { id } = await job({ requirements });
  const { fits } = await iteration(id);
  const at = `/v1/jobs/${id}/iterations`;
  const spec = fits[0].spec;
  await call("POST", `${at}/1/fits`, {
    ...spec,
    regularization: { ...spec.regularization, lambda_star: { criterion: "l_curve" } },
    reason: "what l_curve makes of it",
  });
  await call("POST", `${at}/1/evaluations`, await evaluation(nodes));
  await call("POST", `${at}/1/pitch`, JSON.parse(await example("requests/iteration_pitch.json")));
  const correction = JSON.parse(await example("requests/iteration_correction.json"));
  // the requirements of the job stay
  Object.assign(correction.limits, { profile_crowning: { fixed: true }, helix_crowning: { fixed: true } });
  await call("POST", `${at}/1/correction`, correction);
  await decide(world, `${at}/1`, "remachine");
  await iteration(id, "flank_z52_remachined.json");
  await decide(world, `${at}/2`, "accepted");
  return id;
}

/** @param {string} id @returns {Picture[]} */
function pictures(id) {
  const first = `/jobs/${id}/iterations/1`;
  return [
    { name: "list", place: "/jobs", height: 860 },
    { name: "flank-2d", place: `${first}?contours=1&lines=1&at=8.742,7.5`, height: 1000 },
    { name: "flank-3d", place: `${first}?space=1&lines=1`, height: 1060, ready: ".flank-3d canvas" },
    { name: "lambda", place: `${first}/lambda?by=discrepancy`, height: 1770 },
    { name: "statistics", place: `${first}/statistics?direction=1`, height: 1180 },
    { name: "job", place: `/jobs/${id}`, height: 1460 },
    { name: "evaluation", place: `${first}/evaluation`, height: 1350 },
    { name: "pitch", place: `${first}/evaluation`, height: 1300, at: "#pitch" },
    { name: "correction", place: `${first}/correction`, height: 1250 },
    { name: "trace", place: `/jobs/${id}/trace`, height: 1450 },
    { name: "tablet-dark", place: `${first}?contours=1`, look: "tablet" },
    { name: "report", place: `/jobs/${id}/report`, height: 1720 },
  ];
}

test("pictures of the dashboard", async () => {
  const server = await serve();
  after(async () => {
    await server.stop();
    await rm(server.folder, { recursive: true, force: true });
  });
  await mkdir(folder, { recursive: true });
  /** @type {Picture[] | undefined} */
  let list;
  for (const [look, options] of Object.entries(LOOKS)) {
    await inBrowser(server, options, async (world) => {
      list ??= pictures(await jobs(world));
      for (const { name, place, height, ready, at, look: own = "desktop" } of list) {
        if (own !== look) continue;
        const { page } = world;
        await page.setViewportSize({ ...options.context.viewport, ...(height ? { height } : {}) });
        await world.open(place);
        if (ready) await page.locator(ready).waitFor();
        if (at) await page.locator(at).evaluate((one) => one.scrollIntoView());
        const whole = await page.screenshot({ animations: "disabled" });
        const png = whole.length <= MOST_BYTES ? whole : palettePng(whole);
        assert.ok(png.length <= MOST_BYTES, `${name}: ${png.length} bytes`);
        await writeFile(path.join(folder, `${name}.png`), png);
        console.log(`${name}.png: ${Math.round(png.length / 1000)} kB`);
      }
    });
  }
});
