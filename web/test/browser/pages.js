// Every page with something on it, for what holds of all of them. A new page adds a line.

import { example } from "./harness.js";

/** @param {import("./harness.js").World} world @returns {Promise<{ name: string, path: string }[]>} */
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
  const empty = await job({ name: "Sun gear, hobbed", gear: undefined, tags: {} });
  const stream = await call("POST", `/v1/jobs/${id}/streams`, await example("requests/stream.json"));
  await call("POST", `/v1/streams/${stream.id}/nodes`, await example("requests/stream_block.json"));
  return [
    { name: "jobs", path: "/jobs" },
    { name: "new-job", path: "/jobs/new" },
    { name: "job", path: `/jobs/${id}` },
    { name: "job-empty", path: `/jobs/${empty.id}` },
    { name: "iteration", path: `/jobs/${id}/iterations/1?contours=1` },
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
  ];
}
