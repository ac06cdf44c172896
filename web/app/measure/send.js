// Sends one file: as JSON, as a table beside its request, or to be imported.

import { api } from "../api/client.js";
import { answerLater } from "../api/later.js";
import { mappingOf } from "../lib/nodes_table.js";
import { importSpecOf, specOf } from "./request.js";

/** @typedef {import("./read.js").Content} Content */

/** The file was written anew since it was read: no longer what was shown. */
export class ChangedError extends Error {}

/**
 * @param {string} jobId @param {File} file @param {Content} content @param {import("./request.js").Typed} typed
 * @param {import("../api/attempt.js").Attempt} attempt keeps its key over retries of the same
 * @param {Parameters<typeof answerLater>[1]} watch
 */
export async function send(jobId, file, content, typed, attempt, watch) {
  // sent all the same, it would fail as if nobody had answered
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
    return answerLater(
      ({ header, signal }) =>
        api.POST("/v1/jobs/{job_id}/import", {
          signal,
          params: { path, header: { ...key, ...header } },
          body: { file: file.name },
          bodySerializer: () => form,
        }),
      watch,
    );
  }
  const spec = specOf(typed, content);
  const key = attempt.headers([...named, spec]);
  /** @param {object} sent */
  const post = (sent) =>
    answerLater(
      ({ header, signal }) =>
        api.POST("/v1/jobs/{job_id}/iterations", {
          signal,
          params: { path, header: { ...key, ...header } },
          .../** @type {{ body: never }} */ (sent),
        }),
      watch,
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
