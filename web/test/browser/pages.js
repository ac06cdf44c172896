// Every page with content, and every dialog, for checks of all of them. A new one adds a line.

import { example } from "./harness.js";

/** @typedef {import("./harness.js").World} World */
/** @typedef {{ name: string, open: string }} Opened a dialog, and what opens it in whatever language */
/**
 * @typedef {object} Listed
 * @property {string} name
 * @property {string} path
 * @property {(world: World) => Promise<void>} [fill] puts something on the page that no address can
 * @property {readonly Opened[]} [dialogs]
 */

/** Goes to a page of the list. @param {World} world @param {Listed} listed */
export async function visit(world, { path, fill }) {
  await world.open(path);
  if (!fill) return;
  await fill(world);
  await world.loaded();
}

/** Opens a dialog of the page that is shown. @param {World} world @param {Opened} dialog */
export async function opens({ page }, { open }) {
  await page.locator(open).click();
  await page.locator("dialog[open]").waitFor();
}

/** Closes it. @param {World} world */
export async function closes({ page }) {
  await page.keyboard.press("Escape");
  await page.locator("dialog[open]").waitFor({ state: "detached" });
}

/**
 * A job with both flanks measured, corrected by settings for both and for each.
 * @param {Pick<World, "job" | "iteration" | "call">} world
 */
export async function gearCorrected({ job, iteration, call }) {
  const { requirements } = JSON.parse(await example("requests/job_requirements.json"));
  const { id } = await job({ name: "Pump gear, both flanks", requirements });
  await iteration(id);
  await iteration(id, "flank_z52_right.json");
  await call("POST", `/v1/jobs/${id}/correction`, await example("requests/gear_correction.json"));
  return id;
}

/** @param {World} world @returns {Promise<Listed[]>} */
export async function pageList({ job, iteration, call }) {
  const { requirements } = JSON.parse(await example("requests/job_requirements.json"));
  const { id } = await job({ requirements });
  await iteration(id);
  await call("PATCH", `/v1/jobs/${id}/iterations/1`, { decision: "remachine", reason: "f_Hα is beyond class 5" });
  await iteration(id, "flank_z52_remachined.json");
  const correction = JSON.parse(await example("requests/iteration_correction.json"));
  await call("POST", `/v1/jobs/${id}/iterations/1/correction`, correction);
  await call("POST", `/v1/jobs/${id}/iterations/1/evaluations`, await example("requests/gear_evaluate.json"));
  await call("POST", `/v1/jobs/${id}/iterations/1/pitch`, await example("requests/iteration_pitch.json"));
  // an iteration that is of no tooth may have deviations of any
  const { flank: _, tooth: __, ...nodes } = JSON.parse(await example("flank_z52.json"));
  const round = await job({ name: "Pump gear, all around" });
  await call("POST", `/v1/jobs/${round.id}/iterations`, nodes);
  const teeth = JSON.parse(await example("requests/iteration_deviations.json"));
  for (const [tooth, flank] of [
    [1, "left"],
    [2, "left"],
    [1, "right"],
  ]) {
    const grid = { ...teeth.grid, tooth, flank };
    await call("POST", `/v1/jobs/${round.id}/iterations/1/deviations`, { ...teeth, grid });
  }
  const both = await gearCorrected({ job, iteration, call });
  const empty = await job({ name: "Sun gear, hobbed", gear: undefined, tags: {} });
  const stream = await call("POST", `/v1/jobs/${id}/streams`, await example("requests/stream.json"));
  await call("POST", `/v1/streams/${stream.id}/nodes`, await example("requests/stream_block.json"));
  const flank = JSON.parse(await example("flank_z52.json"));
  const weights = await job({ name: "robust" });
  const loss = { type: "m_estimator", loss: "huber" };
  await call("POST", `/v1/jobs/${weights.id}/iterations`, { ...flank, estimator: loss });
  const file = { name: "flank.json", mimeType: "application/json", buffer: Buffer.from(JSON.stringify(flank)) };
  const comma = (/** @type {number | null} */ number) => String(number ?? "").replace(".", ",");
  const table = [
    "Wälzlänge [mm];Zahnbreite [mm];Abweichung [µm]",
    ...flank.nodes.u.flatMap((/** @type {number} */ u, /** @type {number} */ i) =>
      flank.nodes.v.map((/** @type {number} */ v, /** @type {number} */ j) =>
        [u, v, flank.nodes.z[i][j]].map(comma).join(";"),
      ),
    ),
  ].join("\n");
  const first = `/jobs/${id}/iterations/1`;
  const edit = ".page-head .actions .button";
  return [
    { name: "jobs", path: "/jobs" },
    { name: "new-job", path: "/jobs/new" },
    { name: "job", path: `/jobs/${id}`, dialogs: [{ name: "edit-job", open: edit }] },
    {
      name: "job-empty",
      path: `/jobs/${empty.id}`,
      dialogs: [{ name: "delete-job", open: `${edit}:nth-of-type(2)` }],
    },
    { name: "job-gear", path: `/jobs/${both}` },
    {
      name: "iteration",
      path: `${first}?contours=1&lines=1&at=8.742%2C7.5`,
      dialogs: [{ name: "decide", open: "section[aria-labelledby=decision] .actions > :last-child" }],
    },
    { name: "in-space", path: `/jobs/${weights.id}/iterations/1?space=1` },
    { name: "all-teeth", path: `/jobs/${round.id}/iterations/1?layer=teeth` },
    { name: "measure-empty", path: `/jobs/${id}/measure` },
    {
      name: "measure",
      path: `/jobs/${id}/measure`,
      fill: async ({ page }) => {
        await page.setInputFiles("#measure-files", file);
        await page.locator(".queue-entry canvas").waitFor();
      },
    },
    {
      name: "measure-table",
      path: `/jobs/${id}/measure`,
      fill: async ({ page }) => {
        await page.setInputFiles("#measure-files", {
          name: "flank.csv",
          mimeType: "text/csv",
          buffer: Buffer.from(table),
        });
        await page.locator(".queue-entry canvas").waitFor();
      },
    },
    {
      name: "lambda",
      path: `${first}/lambda?by=discrepancy`,
      dialogs: [{ name: "keep", open: ".lambda-shown .button.primary" }],
    },
    { name: "evaluation", path: `${first}/evaluation` },
    { name: "evaluation-empty", path: `/jobs/${id}/iterations/2/evaluation` },
    { name: "correction", path: `${first}/correction` },
    { name: "correction-empty", path: `/jobs/${id}/iterations/2/correction` },
    {
      name: "stream",
      path: `/jobs/${id}/streams/${stream.id}`,
      dialogs: [{ name: "finish-stream", open: ".panel .button.primary" }],
    },
    { name: "fit-empty", path: "/fit" },
    {
      name: "fit",
      path: "/fit",
      fill: async ({ page }) => {
        await page.locator("main input[type=file]").first().setInputFiles(file);
        await page.locator(".facts").first().waitFor();
        const gear = page.locator("[aria-labelledby=measurand] input");
        await gear.nth(0).fill("52");
        await gear.nth(1).fill("1");
        await page.locator(".figure-tiles").waitFor();
      },
    },
    { name: "trace", path: `/jobs/${id}/trace` },
    { name: "report", path: `/jobs/${id}/report` },
    { name: "report-empty", path: `/jobs/${empty.id}/report` },
    { name: "statistics", path: `${first}/statistics?direction=1` },
    { name: "weights", path: `/jobs/${weights.id}/iterations/1/statistics` },
    { name: "settings", path: "/settings", dialogs: [{ name: "enter-key", open: "[aria-labelledby=access] .button" }] },
  ];
}
