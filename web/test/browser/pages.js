// Every page with something on it, and every dialog, for what holds of all of them. A new one adds a line.

import { example } from "./harness.js";

/** @typedef {import("./harness.js").World} World */
/** @typedef {{ name: string, path: string, open?: string }} Listed `open`: what opens a dialog there, in whatever language */

/** Goes to a page of the list, and opens its dialog. @param {World} world @param {Listed} listed */
export async function visit({ page, open }, { path, open: opener }) {
  await open(path);
  if (!opener) return;
  await page.locator(opener).click();
  await page.locator("dialog[open]").waitFor();
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
  const empty = await job({ name: "Sun gear, hobbed", gear: undefined, tags: {} });
  const stream = await call("POST", `/v1/jobs/${id}/streams`, await example("requests/stream.json"));
  await call("POST", `/v1/streams/${stream.id}/nodes`, await example("requests/stream_block.json"));
  return [
    { name: "jobs", path: "/jobs" },
    { name: "new-job", path: "/jobs/new" },
    { name: "job", path: `/jobs/${id}` },
    { name: "job-empty", path: `/jobs/${empty.id}` },
    { name: "iteration", path: `/jobs/${id}/iterations/1?contours=1` },
    { name: "all-teeth", path: `/jobs/${round.id}/iterations/1?layer=teeth` },
    { name: "measure", path: `/jobs/${id}/measure` },
    { name: "lambda", path: `/jobs/${id}/iterations/1/lambda?by=discrepancy` },
    { name: "evaluation", path: `/jobs/${id}/iterations/1/evaluation` },
    { name: "evaluation-empty", path: `/jobs/${id}/iterations/2/evaluation` },
    { name: "correction", path: `/jobs/${id}/iterations/1/correction` },
    { name: "correction-empty", path: `/jobs/${id}/iterations/2/correction` },
    { name: "stream", path: `/jobs/${id}/streams/${stream.id}` },
    { name: "fit-empty", path: "/fit" },
    { name: "trace", path: `/jobs/${id}/trace` },
    { name: "report", path: `/jobs/${id}/report` },
    { name: "report-empty", path: `/jobs/${empty.id}/report` },
    { name: "statistics", path: `/jobs/${id}/iterations/1/statistics?direction=1` },
    { name: "settings", path: "/settings" },
    { name: "edit-job", path: `/jobs/${id}`, open: ".page-head .actions .button" },
    { name: "delete-job", path: `/jobs/${empty.id}`, open: ".page-head .actions .button:nth-of-type(2)" },
    { name: "decide", path: `/jobs/${id}/iterations/1`, open: ".flank-beside .button.danger" },
    { name: "keep", path: `/jobs/${id}/iterations/1/lambda?by=gcv`, open: ".lambda-shown .button.primary" },
    { name: "finish-stream", path: `/jobs/${id}/streams/${stream.id}`, open: ".panel .button.primary" },
    { name: "enter-key", path: "/settings", open: "[aria-labelledby=access] .button" },
  ];
}
