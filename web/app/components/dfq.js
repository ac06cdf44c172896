// Results of an iteration as quality data (DFQ) for statistical process control.

import { transport } from "../api/client.js";
import { t as common } from "../i18n/common.js";
import { t } from "../i18n/evaluation.js";
import { download } from "../lib/csv.js";
import { html } from "../../vendor/ui.js";
import { notify } from "./toast.js";

/** @param {{ jobId: string, number: number, record: string, name: string }} props `record`: of an evaluation or of pitches */
export function Dfq({ jobId, number, record, name }) {
  const save = async () => {
    const headers = { accept: "application/x-q-das-dfq" };
    const request = new Request(`/v1/jobs/${jobId}/iterations/${number}/records/${record}`, { headers });
    try {
      const response = await transport(request);
      if (!response.ok) throw new Error(`HTTP ${response.status}`);
      // unchanged: not every file is UTF-8
      download(`${name}.dfq`, await response.blob());
    } catch (error) {
      notify(`${common.pageFailed}: ${error instanceof Error ? error.message : error}`, "failed");
    }
  };
  return html`<button type="button" class="button small" title=${t.dfqHint} onClick=${save}>${t.dfq}</button>`;
}
