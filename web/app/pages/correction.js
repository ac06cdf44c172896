// The correction of an iteration: what to change at the machine, and what the next iteration says of it.

import { answer, api, transport } from "../api/client.js";
import { useRecords } from "../api/records.js";
import { useResource } from "../api/resource.js";
import { Allowed } from "../components/allowed.js";
import { Applied } from "../components/applied.js";
import { CorrectionForm } from "../components/correction_form.js";
import { CorrectionMaps } from "../components/correction_maps.js";
import { Answer, Apart, Changes, Figures, outsideOf } from "../components/correction_result.js";
import { Facts } from "../components/figure.js";
import { JobPage, useNews } from "../components/job_page.js";
import { Empty, loaded } from "../components/states.js";
import { notify } from "../components/toast.js";
import { t as common } from "../i18n/common.js";
import { t } from "../i18n/correction.js";
import { fmt } from "../i18n/i18n.js";
import { download } from "../lib/csv.js";
import { toMeasure } from "../router.js";
import { WarningList } from "../components/warnings.js";
import { h, html } from "../../vendor/ui.js";

/** @typedef {import("../api/client.js").Schema<"KeptCorrection">} KeptCorrection */
/** @typedef {import("../api/client.js").Schema<"Iteration">} Iteration */
/** @typedef {import("../api/client.js").Schema<"Job">} Job */
/** @typedef {import("../api/client.js").Schema<"CorrectionRequest">} CorrectionRequest */

export const styles = ["correction"];

/** @param {{ params: Record<string, string> }} props */
export default function CorrectionPage({ params }) {
  const [jobId, number] = [params["job_id"] ?? "", Number(params["number"])];
  return h(JobPage, {
    key: `${jobId} ${number}`,
    jobId,
    view: t.title,
    number,
    children: (job, { news }) => h(Correction, { job, number, news }),
  });
}

/** @param {{ job: Job, number: number, news: number }} props */
function Correction({ job, number, news }) {
  const path = { job_id: job.id, number };
  const iteration = useResource(`iteration ${job.id} ${number}`, (signal) =>
    answer(api.GET("/v1/jobs/{job_id}/iterations/{number}", { signal, params: { path } })),
  );
  const records = useRecords(job.id, number);
  const made = records.data?.filter(({ kind }) => kind === "correction") ?? [];
  const latest = made.at(-1);
  const kept = useResource(latest ? `correction ${job.id} ${number} ${latest.id}` : null, async (signal) => {
    const params = { path, query: { include: /** @type {["nodes"]} */ (["nodes"]) } };
    const { data } = await answer(api.GET("/v1/jobs/{job_id}/iterations/{number}/correction", { signal, params }));
    return { data: /** @type {KeptCorrection} */ (data) };
  });
  useNews(news, [iteration, records, kept]);
  const form = (/** @type {Iteration} */ { node_count }) =>
    h(Allowed, {
      scope: "judge",
      children: () =>
        h(CorrectionForm, {
          key: latest?.id ?? "",
          jobId: job.id,
          number,
          nodeCount: node_count,
          hasGear: Boolean(job.gear),
          last: /** @type {CorrectionRequest | undefined} */ (kept.data?.request),
          onDone: () => {
            records.reload();
            scrollTo(0, 0);
          },
        }),
    });
  return loaded({
    resource: iteration,
    children: (of) =>
      loaded({
        resource: records,
        children: () =>
          latest
            ? loaded({
                resource: kept,
                lines: 12,
                children: (correction) => html`
                  ${h(Kept, { job, iteration: of, kept: correction, earlier: made.length - 1, onApplied: kept.reload })}
                  <details class="panel another"><summary><h2>${t.another}</h2></summary>${form(of)}</details>`,
              })
            : html`${h(Empty, { children: t.none })}
                <section class="panel" aria-labelledby="new-correction"><h2 id="new-correction">${t.first}</h2>${form(of)}</section>`,
      }),
  });
}

/** @param {{ job: Job, iteration: Iteration, kept: KeptCorrection, earlier: number, onApplied: () => void }} props */
function Kept({ job, iteration, kept, earlier, onApplied }) {
  const { result, answer: measured, not_compared: refused } = kept;
  const name = `${job.name} ${iteration.number}`;
  const nodes = useResource(`nodes ${job.id} ${iteration.number}`, async (signal) => {
    const params = { path: { job_id: job.id, number: iteration.number } };
    const { data } = await answer(api.GET("/v1/jobs/{job_id}/iterations/{number}/nodes", { signal, params }));
    return { data: /** @type {import("../api/client.js").Schema<"Nodes">} */ (data) };
  });
  const measure = toMeasure(job.id);
  const tools = html`<button type="button" class="button small" onClick=${() => saveForMachine(job.id, iteration.number, name, result)}>${t.csvForMachine}</button>`;
  return html`
    <section class="panel" aria-labelledby="changes">
      <header><h2 id="changes">${t.changes}</h2></header>
      ${h(Facts, { items: factsOf(kept, iteration) })}
      <p class="quiet">${t.changesAbout} ${t.errorAbout}${earlier > 0 && html` ${t.earlier(earlier)}`}</p>
      ${h(Changes, { result, csvName: `${name} ${t.changes}`, tools })}
    </section>
    <section class="panel" aria-labelledby="entered">
      <h2 id="entered">${t.enteredTitle}</h2>
      ${h(Applied, { jobId: job.id, number: iteration.number, kept, onDone: onApplied })}
    </section>
    <section class="panel" aria-labelledby="apart"><h2 id="apart">${t.apart}</h2>${h(Apart, { result })}</section>
    <section class="panel" aria-labelledby="answered">
      <header>
        <h2 id="answered">${t.answered}</h2>
        ${measured && html`<p class="quiet">${t.answeredBy(measured.iteration)}</p>`}
      </header>
      ${measured && h(Answer, { answer: measured, entered: Boolean(kept.applied) })}
      ${!measured && refused && html`<p>${t.notCompared} <span lang="en">${refused}</span></p>`}
      ${
        !measured &&
        !refused &&
        html`<p>${t.notMeasured}</p>
          ${measure && html`<p class="actions"><a class="button" href=${measure}>${t.measure}</a></p>`}`
      }
    </section>
    <section class="panel" aria-labelledby="figures">
      <h2 id="figures">${measured ? t.figures : t.figuresBefore}</h2>
      <p class="quiet">${result.predicted.figures ? t.figuresAbout : t.noFigures}</p>
      ${h(Figures, { kept, csvName: `${name} ${t.figures}` })}
    </section>
    <section class="panel" aria-labelledby="maps">
      <h2 id="maps">${t.maps}</h2>
      <p class="quiet">${t.mapsAbout}</p>
      ${loaded({ resource: nodes, children: (all) => h(CorrectionMaps, { nodes: all, axes: iteration.axes, kept }) })}
    </section>
    ${
      result.warnings.length > 0 &&
      html`<section class="panel" aria-labelledby="warnings">
        <h2 id="warnings">${t.warnings}</h2>
        ${h(WarningList, { warnings: result.warnings })}
      </section>`
    }`;
}

/** @param {KeptCorrection} kept @param {Iteration} iteration */
function factsOf(kept, iteration) {
  const known = kept.method === "form_grinding" || kept.method === "generating_grinding" || kept.method === "matrix";
  return [
    { name: t.madeBy, value: known ? t[/** @type {"matrix"} */ (kept.method)] : data(kept.method) },
    { name: t.aim, value: t[`aim_${kept.result.target.kind}`] },
    { name: t.madeAt, value: data(fmt.value.time(kept.created_at)) },
    ...(iteration.tooth ? [{ name: t.tooth, value: data(iteration.tooth) }] : []),
    ...(iteration.flank ? [{ name: t.flank, value: t[iteration.flank] }] : []),
  ];
}

/** Saves the CSV for the control, as the interface writes it. @param {string} jobId @param {number} number @param {string} name @param {KeptCorrection["result"]} result */
async function saveForMachine(jobId, number, name, result) {
  const outside = outsideOf(result);
  if (outside.length > 0 && !confirm(t.outsideLimits(outside.join(", ")))) return;
  const query = outside.length > 0 ? "?outside_limits=allowed" : "";
  const place = `/v1/jobs/${encodeURIComponent(jobId)}/iterations/${number}/correction${query}`;
  try {
    const response = await transport(new Request(place, { headers: { accept: "text/csv" } }));
    if (!response.ok) throw new Error(`HTTP ${response.status}`);
    download(`${name} ${t.title}.csv`, await response.text());
  } catch (error) {
    notify(`${common.pageFailed}: ${error instanceof Error ? error.message : error}`, "failed");
  }
}

/** @param {string} text */
const data = (text) => html`<span translate="no">${text}</span>`;
