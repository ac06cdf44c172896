// Statistics of a fit: spectrum, collinearity, residuals, how it was computed.

import { answer, api } from "../api/client.js";
import { useResource } from "../api/resource.js";
import { JobPage } from "../components/job_page.js";
import { loaded } from "../components/states.js";
import { Warnings } from "../flank/figures.js";
import { useFit, useNodes } from "../flank/use_layers.js";
import { t as common } from "../i18n/common.js";
import { query } from "../navigation.js";
import { Collinearity } from "../statistics/collinearity.js";
import { Provenance } from "../statistics/provenance.js";
import { Residuals } from "../statistics/residuals.js";
import { Spectrum } from "../statistics/spectrum.js";
import { h, html } from "../../vendor/ui.js";

/** @typedef {import("../api/client.js").Schema<"Iteration">} Iteration */

export const styles = ["statistics"];

/** @param {{ params: Record<string, string> }} props */
export default function Statistics({ params }) {
  const path = { job_id: params["job_id"] ?? "", number: Number(params["number"]) };
  const iteration = useResource(`iteration ${path.job_id} ${path.number}`, (signal) =>
    answer(api.GET("/v1/jobs/{job_id}/iterations/{number}", { signal, params: { path } })),
  );
  return h(JobPage, {
    jobId: path.job_id,
    view: `${common.statistics} ${common.iteration(path.number)}`,
    number: path.number,
    onEvents: iteration.reload,
    children: () => loaded({ resource: iteration, lines: 14, children: (data) => h(OfFit, { iteration: data }) }),
  });
}

/** @param {{ iteration: Iteration }} props */
function OfFit({ iteration }) {
  const path = { job_id: iteration.job_id, number: iteration.number };
  const id = query.value.get("fit") ?? iteration.fits.find(({ chosen }) => chosen)?.id;
  const fit = useFit(path.job_id, path.number, id, ["residuals", "collinearity", "robust_weights"]);
  const nodes = useNodes(path.job_id, path.number);
  return loaded({
    resource: fit,
    lines: 14,
    children: (data) => html`<div class="statistics-page">
      ${h(Spectrum, { fit: data })}
      ${h(Residuals, { result: data.result, nodes: nodes.data, axes: iteration.axes })}
      ${h(Warnings, { result: data.result, half: true })}
      ${h(Collinearity, { result: data.result })}
      ${h(Provenance, { fit: data, path })}
    </div>`,
  });
}
