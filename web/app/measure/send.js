// Sends one file: as JSON, as a table beside its request, or to be imported.

import { answer, api } from "../api/client.js";
import { importSpecOf, specOf } from "./request.js";

/** @typedef {import("./read.js").Content} Content */

/**
 * @param {string} jobId @param {File} file @param {Content} content @param {import("./request.js").Typed} typed
 * @param {import("../api/client.js").Attempt} attempt keeps its key over retries of the same
 * @param {AbortSignal} signal
 */
export function send(jobId, file, content, typed, attempt, signal) {
  const named = [file.name, file.size, file.lastModified];
  const path = { job_id: jobId };
  if (content.kind === "import") {
    const spec = importSpecOf(typed);
    const form = new FormData();
    form.append("file", file, file.name);
    if (Object.keys(spec).length > 0) form.append("spec", json(spec));
    const params = { path, header: attempt.headers([...named, spec]) };
    return answer(
      api.POST("/v1/jobs/{job_id}/import", { signal, params, body: { file: file.name }, bodySerializer: () => form }),
    );
  }
  const spec = specOf(typed, content);
  const params = { path, header: attempt.headers([...named, spec]) };
  if (content.kind === "csv") {
    const form = new FormData();
    form.append("spec", json(spec));
    form.append("nodes", new Blob([file], { type: "text/csv" }), "nodes.csv");
    const body = /** @type {never} */ ({});
    return answer(api.POST("/v1/jobs/{job_id}/iterations", { signal, params, body, bodySerializer: () => form }));
  }
  const body = /** @type {never} */ ({ ...spec, nodes: content.request?.["nodes"] });
  return answer(api.POST("/v1/jobs/{job_id}/iterations", { signal, params, body }));
}

/** @param {object} value */
const json = (value) => new Blob([JSON.stringify(value)], { type: "application/json" });
