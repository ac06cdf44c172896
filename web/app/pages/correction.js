// The correction of an iteration: the changes at the machine, and the response in the next
// iteration.

import { answer, api } from "../api/client.js";
import { useRecords } from "../api/records.js";
import { useResource } from "../api/resource.js";
import { Allowed } from "../components/allowed.js";
import { Applied } from "../components/applied.js";
import { CorrectionForm } from "../components/correction_form.js";
import { CorrectionMaps } from "../components/correction_maps.js";
import { ControlCsv } from "../components/control_csv.js";
import { Answer, Indistinguishable, Changes, Figures, factsOf, requestOf } from "../components/correction_result.js";
import { Facts } from "../components/figure.js";
import { JobPage, useNews } from "../components/job_page.js";
import { loaded } from "../components/states.js";
import { OtherFlank } from "../components/other_flank.js";
import { t } from "../i18n/correction.js";
import { toMeasure } from "../router.js";
import { WarningList } from "../components/warnings.js";
import { h, html } from "../../vendor/ui.js";

/** @typedef {import("../api/client.js").Schema<"Correction">} Correction */
/** @typedef {import("../api/client.js").Schema<"Iteration">} Iteration */
/** @typedef {import("../api/client.js").Schema<"Job">} Job */

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
    return { data: /** @type {Correction} */ (data) };
  });
  useNews(news, [iteration, records, kept]);
  const form = (/** @type {Iteration} */ { node_count }) =>
    h(Allowed, {
      scope: "decide",
      children: () =>
        h(CorrectionForm, {
          key: latest?.id ?? "",
          jobId: job.id,
          number,
          nodeCount: node_count,
          hasGear: Boolean(job.gear),
          last: kept.data && requestOf(kept.data),
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
            : html`<section class="panel" aria-labelledby="new-correction">
                <h2 id="new-correction">${t.first}</h2>
                <p class="quiet">${t.none}</p>
                ${form(of)}
              </section>`,
      }),
  });
}

/** @param {{ job: Job, iteration: Iteration, kept: Correction, earlier: number, onApplied: () => void }} props */
function Kept({ job, iteration, kept, earlier, onApplied }) {
  const { result, answer: measured, not_compared: refused } = kept;
  const name = `${job.name} ${iteration.number}`;
  const nodes = useResource(`nodes ${job.id} ${iteration.number}`, async (signal) => {
    const params = { path: { job_id: job.id, number: iteration.number } };
    const { data } = await answer(api.GET("/v1/jobs/{job_id}/iterations/{number}/nodes", { signal, params }));
    return { data: /** @type {import("../api/client.js").Schema<"Nodes">} */ (data) };
  });
  const { sensitivity } = requestOf(kept);
  const machine = sensitivity.type === "machine" ? sensitivity : undefined;
  const chosen = machine?.flank;
  // a request without a flank uses that of the iteration at the time
  const of = chosen ?? /** @type {const} */ (["left", "right"]).find((side) => result.figures?.[side]);
  const changed = machine && of && iteration.flank && of !== iteration.flank && t.changedFlank(iteration.flank, of);
  const measure = toMeasure(job.id);
  const owner = `${encodeURIComponent(job.id)}/iterations/${iteration.number}`;
  return html`
    <section class="panel" aria-labelledby="changes">
      <header><h2 id="changes">${t.changes}</h2></header>
      ${h(Facts, {
        items: [
          ...factsOf(kept),
          ...(iteration.tooth ? [{ name: t.tooth, value: data(iteration.tooth) }] : []),
          ...(iteration.flank ? [{ name: t.flank, value: t[iteration.flank] }] : []),
        ],
      })}
      <p class="quiet">${t.changesAbout} ${t.errorAbout}${earlier > 0 && html` ${t.earlier(earlier)}`}</p>
      ${chosen && !iteration.flank && html`<p class="note warn">${t.chosenFlank(chosen)}</p>`}
      ${changed && html`<p class="note warn">${changed}</p>`}
      ${h(Changes, { result, csvName: `${name} ${t.changes}`, tools: h(ControlCsv, { owner, name, result }) })}
    </section>
    <section class="panel" aria-labelledby="entered">
      <h2 id="entered">${t.enteredTitle}</h2>
      ${h(Applied, { job, number: iteration.number, kept, onDone: onApplied })}
    </section>
    ${
      result.indistinguishable.length > 0 &&
      html`<section class="panel" aria-labelledby="indistinguishable"><h2 id="indistinguishable">${t.indistinguishable}</h2>${h(Indistinguishable, { result })}</section>`
    }
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
      <p class="quiet">${result.figures ? t.figuresAbout : t.noFigures}</p>
      ${h(Figures, { kept, csvName: `${name} ${t.figures}` })}
    </section>
    ${result.other_flank && h(OtherFlank, { kept, other: result.other_flank })}
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

/** @param {string} text */
const data = (text) => html`<span translate="no">${text}</span>`;
