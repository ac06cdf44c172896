// The report of a job: a print preview on the screen.

import { JobPage } from "../components/job_page.js";
import { Empty, loaded, measureAction } from "../components/states.js";
import { t as common } from "../i18n/common.js";
import { fmt } from "../i18n/i18n.js";
import { t } from "../i18n/report.js";
import { query } from "../navigation.js";
import { Bar } from "../report/bar.js";
import { Corrections } from "../report/correction.js";
import { Cover } from "../report/cover.js";
import { useReport } from "../report/data.js";
import { Evaluations } from "../report/evaluation.js";
import { Maps } from "../report/maps.js";
import { showBoxes } from "../report/page_boxes.js";
import { iterationsOf, partsOf } from "../report/parts.js";
import { Pitches } from "../report/pitch.js";
import { Choices, Spectra } from "../report/regularization.js";
import { Origin, Story, Warnings } from "../report/story.js";
import { languageOfPage } from "../settings.js";
import { h, html, useEffect, useLayoutEffect } from "../../vendor/ui.js";

/** @typedef {import("../api/job.js").Job} Job */
/** @typedef {import("../api/job.js").TracedIteration} TracedIteration */
/** @typedef {import("../report/data.js").ReportData} ReportData */

export const styles = ["iteration", "evaluation", "correction", "report"];

/** @param {{ params: Record<string, string> }} props */
export default function ReportPage({ params }) {
  const jobId = params["job_id"] ?? "";
  const lang = query.value.get("lang");
  useLayoutEffect(() => {
    languageOfPage.value = lang === "de" || lang === "en" ? lang : undefined;
    return () => {
      languageOfPage.value = undefined;
    };
  }, [lang]);
  return h(JobPage, {
    jobId,
    view: common.report,
    children: (job, { trace }) =>
      loaded({ resource: trace, lines: 14, children: ({ iterations }) => h(Report, { job, iterations }) }),
  });
}

/** @param {{ job: Job, iterations: readonly TracedIteration[] }} props */
function Report({ job, iterations }) {
  const there = iterations.map(({ number }) => number);
  const numbers = iterationsOf(query.value.get("iterations"), there);
  const report = useReport(job, iterations, numbers);
  const date = fmt.value.date(new Date());
  useEffect(() => showBoxes({ job: job.name, date, page: t.page }), [job.name, date, t.page]);
  if (there.length === 0) return h(Empty, { children: t.nothing, action: measureAction(job.id) });
  return html`<div class="report-page">
    ${h(Bar, { there, numbers, printable: report.data !== undefined })}
    ${loaded({ resource: report, lines: 20, children: (data) => h(Paper, { job, data, iterations }) })}
  </div>`;
}

/** @param {{ job: Job, data: readonly ReportData[], iterations: readonly TracedIteration[] }} props */
function Paper({ job, data, iterations }) {
  const flipU = job.gear?.internal === true;
  const parts = partsOf(query.value.get("parts"));
  /** @type {Record<Exclude<typeof parts[number], "summary">, () => import("../../vendor/ui.js").VNode>} */
  const made = {
    maps: () => h(Maps, { data, flipU }),
    evaluation: () => h(Evaluations, { data }),
    pitch: () => h(Pitches, { data }),
    lambda: () => h(Choices, { data }),
    spectrum: () => h(Spectra, { data }),
    correction: () => h(Corrections, { data }),
    trace: () => h(Story, { iterations }),
    warnings: () => h(Warnings, { data }),
    provenance: () => h(Origin, { jobId: job.id, data }),
  };
  return html`<div class="report-scroll" role="region" tabindex="0" aria-label=${t.paper}>
    <article class="report">
      ${parts.map((part) =>
        part === "summary"
          ? h(Cover, { key: part, job, data })
          : html`<section key=${part} class=${`report-part ${part}`} aria-labelledby=${`part-${part}`}>
              <h2 id=${`part-${part}`}>${t[part]}</h2>${made[part]()}
            </section>`,
      )}
    </article>
  </div>`;
}
