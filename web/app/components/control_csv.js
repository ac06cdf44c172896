// The CSV of a correction for the machine's controller.

import { transport } from "../api/client.js";
import { t as common } from "../i18n/common.js";
import { t } from "../i18n/correction.js";
import { download } from "../lib/csv.js";
import { html } from "../../vendor/ui.js";
import { outsideOf } from "./correction_result.js";
import { notify } from "./toast.js";

/** @typedef {import("../api/client.js").Schema<"Correction">} Correction */

/** @param {{ owner: string, name: string, result: Correction["result"] }} props `owner`: path of the corrected job or iteration */
export function ControlCsv({ owner, name, result }) {
  const save = async () => {
    const outside = outsideOf(result);
    if (outside.length > 0 && !confirm(t.outsideLimits(outside.join(", ")))) return;
    const query = outside.length > 0 ? "?outside_limits=allowed" : "";
    const request = new Request(`/v1/jobs/${owner}/correction${query}`, { headers: { accept: "text/csv" } });
    try {
      const response = await transport(request);
      if (!response.ok) throw new Error(`HTTP ${response.status}`);
      download(`${name} ${t.title}.csv`, await response.text());
    } catch (error) {
      notify(`${common.pageFailed}: ${error instanceof Error ? error.message : error}`, "failed");
    }
  };
  return html`<button type="button" class="button small" onClick=${save}>${t.csvForMachine}</button>`;
}
