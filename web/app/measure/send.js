// Sends one file: as JSON, as a table with its request, or as an import.

import { answer, api } from "../api/client.js";
import { mappingOf } from "../lib/nodes_table.js";
import { importSpecOf, specOf } from "./request.js";

/** @typedef {import("./read.js").Content} Content */

/** The file was changed since it was read: it differs from what was shown. */
export class ChangedError extends Error {}

/**
 * @param {string} jobId @param {File} file @param {Content} content @param {import("./request.js").Typed} typed
 * @param {import("../api/attempt.js").Attempt} attempt keeps its key over retries of the same
 * @param {import("../api/watched.js").How} how
 */
export async function send(jobId, file, content, typed, attempt, how) {
  // sent anyway, it would fail as if there were no response
  await file
    .slice(0, 1)
    .arrayBuffer()
    .catch((cause) => {
      throw new ChangedError(file.name, { cause });
    });
  const mapping = content.proposal && mappingOf(content.proposal);
  const named = [file.name, content.digest, mapping];
  const path = { job_id: jobId };
  if (content.kind === "import") {
    const spec = importSpecOf(typed);
    const form = new FormData();
    form.append("file", file, file.name);
    if (Object.keys(spec).length > 0) form.append("spec", json(spec));
    if (mapping) form.append("mapping", json(mapping));
    const key = attempt.headers([...named, spec]);
    return answer(
      api.POST("/v1/jobs/{job_id}/import", {
        ...how,
        params: { path, header: key },
        body: { file: file.name },
        bodySerializer: () => form,
      }),
    );
  }
  const spec = specOf(typed, content);
  const key = attempt.headers([...named, spec]);
  /** @param {object} sent */
  const post = (sent) =>
    answer(
      api.POST("/v1/jobs/{job_id}/iterations", {
        ...how,
        params: { path, header: key },
        .../** @type {{ body: never }} */ (sent),
      }),
    );
  if (content.kind === "table") {
    const form = new FormData();
    form.append("spec", json(spec));
    form.append("nodes", file, file.name);
    if (mapping) form.append("mapping", json(mapping));
    return post({ body: {}, bodySerializer: () => form });
  }
  return post({ body: { ...spec, nodes: content.request?.["nodes"] } });
}

/** @param {object} value */
const json = (value) => new Blob([JSON.stringify(value)], { type: "application/json" });
