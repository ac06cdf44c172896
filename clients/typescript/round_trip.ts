// fit → job → iteration → refit → trace → correction with the client that openapi-generator makes for typescript-axios.
//
//     node round_trip.js URL EXAMPLES

import { readFileSync } from "fs";
import { join } from "path";
import axios from "axios";
import {
  Configuration,
  CorrectionRequest,
  FitRequest,
  FitsApi,
  IterationRequest,
  IterationsApi,
  JobsApi,
  NewJob,
  RefitRequest,
} from "./client";

async function main(url: string, examples: string): Promise<void> {
  const example = <T>(name: string): T => JSON.parse(readFileSync(join(examples, `${name}.json`), "utf-8")) as T;
  const held = (holds: boolean, what: string): void => {
    if (!holds) throw new Error(what);
  };
  const configuration = new Configuration({ basePath: url });
  const fits = new FitsApi(configuration);
  const jobs = new JobsApi(configuration);
  const iterations = new IterationsApi(configuration);

  const fit = (await fits.createFit({ fitRequest: example<FitRequest>("fit_grid") })).data;
  console.log(`fit: ${fit.coefficients.length} coefficients`);

  const job = (await jobs.createJob({ newJob: example<NewJob>("job") })).data;
  const iterationRequest = example<IterationRequest>("iteration");
  const made = (await iterations.createIteration({ jobId: job.id, iterationRequest })).data;
  const at = { jobId: job.id, number: made.number };
  held((await iterations.getIteration(at)).data.id === made.id, "another iteration");
  console.log(`job ${job.id}, iteration ${made.number}`);

  const refitRequest = example<RefitRequest>("refit");
  const refit = (await iterations.createIterationFit({ ...at, refitRequest })).data;
  await iterations.chooseFit({ ...at, chosenFit: { fit_id: refit.id, reason: "round trip" } });
  console.log(`refit ${refit.id} stands`);

  const trace = (await iterations.getTrace({ jobId: job.id })).data;
  held(trace.iterations.length === 1 && trace.iterations[0].fits.length === 2, "the trace has lost something");

  const correctionRequest = example<CorrectionRequest>("iteration_correction");
  const correction = (await iterations.createIterationCorrection({ ...at, correctionRequest })).data;
  const kept = (await iterations.getIterationCorrection(at)).data;
  const changes = (settings: { change: number }[]): string => JSON.stringify(settings.map((one) => one.change));
  held(changes(kept.result.settings) === changes(correction.result.settings), "another correction");
  const told = correction.result.settings.map((one) => `${one.name} ${one.change.toPrecision(3)} ${one.unit}`);
  console.log("correction: " + told.join(", "));

  try {
    await jobs.createJob({ newJob: { name: "" } });
    held(false, "an empty name was taken");
  } catch (error) {
    const response = axios.isAxiosError(error) ? error.response : undefined;
    held(response?.status === 422 && response.data.errors[0].pointer === "/name", String(error));
  }
  console.log("round trip: ok");
}

main(process.argv[2], process.argv[3]).catch((error: unknown) => {
  console.error(error);
  process.exit(1);
});
