// A job: its next step and its iterations.

import { answer, api } from "../api/client.js";
import { chosenFit } from "../api/job.js";
import { may } from "../api/key.js";
import { useTolerances } from "../api/tolerances.js";
import { Dialog } from "../components/dialog.js";
import { EditJob } from "../components/edit_job.js";
import { Badge, Facts } from "../components/figure.js";
import { FiguresOfIterations, limitText, figureRows } from "../components/flank_figures.js";
import { GearCorrection } from "../components/gear_correction.js";
import { JobPage } from "../components/job_page.js";
import { RequirementsPanel } from "../components/requirements.js";
import { Empty, Failure, loaded, measureAction } from "../components/states.js";
import { table } from "../components/table.js";
import { GearSymbol } from "../components/symbol.js";
import { Tags } from "../components/tags.js";
import { notify } from "../components/toast.js";
import { Within } from "../components/within.js";
import { t as common } from "../i18n/common.js";
import de from "../i18n/de/job.js";
import en from "../i18n/en/job.js";
import { fmt, texts } from "../i18n/i18n.js";
import { t as requirementText } from "../i18n/requirements.js";
import { ABSENT } from "../lib/format.js";
import { gearInShort } from "../lib/gear.js";
import { requiredLimits } from "../lib/requirements.js";
import { heightUnit } from "../lib/units.js";
import { navigate } from "../navigation.js";
import { href, hrefIf, toMeasure } from "../router.js";
import { h, html, useState } from "../../vendor/ui.js";

/** @typedef {import("../api/job.js").Job} Job */
/** @typedef {import("../api/job.js").TracedIteration} TracedIteration */
/** @typedef {import("../components/job_page.js").JobResource} JobResource */

const t = texts({ en, de });

export const styles = ["job", "correction"];

/** @param {{ params: Record<string, string> }} props */
export default function JobOverview({ params }) {
  const jobId = params["job_id"] ?? "";
  return h(JobPage, {
    jobId,
    actions: (job, { job: resource, trace }) =>
      may("decide") && h(Actions, { job, resource, empty: trace.data?.iterations.length === 0 }),
    children: (job, { trace }) => html`<div class="job-overview">
      ${loaded({
        resource: trace,
        lines: 6,
        children: ({ iterations }) => html`<div class="job-main">
          ${iterations.length === 0 ? h(Unmeasured, { job }) : h(NextStep, { job, last: nextOf(iterations) })}
          ${iterations.length > 0 && h(Figures, { job, iterations })}
          ${iterations.length > 0 && h(Iterations, { job, iterations })}
          ${h(GearCorrection, { job, iterations, onDone: trace.reload })}
          ${h(RequirementsPanel, { requirements: job.requirements, name: job.name })}
        </div>`,
      })}
      ${(trace.data !== undefined || trace.error !== undefined) && h(AboutJob, { job })}
    </div>`,
  });
}

/** Returns the newest iteration of each flank and tooth. @param {readonly TracedIteration[]} iterations */
function newestOf(iterations) {
  return iterations.filter(
    (one, i) => !iterations.slice(i + 1).some(({ flank, tooth }) => flank === one.flank && tooth === one.tooth),
  );
}

const RANKS = /** @type {const} */ ({ rejected: 0, remachine: 1, accepted: 3 });

/** Returns the iteration that determines the status of the job. @param {readonly TracedIteration[]} iterations */
function nextOf(iterations) {
  const rank = (/** @type {TracedIteration} */ { decision }) => (decision ? RANKS[decision] : 2);
  return newestOf(iterations).reduce(
    (/** @type {TracedIteration | undefined} */ first, one) => (first && rank(first) < rank(one) ? first : one),
    undefined,
  );
}

/** Returns the status of each flank. @param {{ iterations: readonly TracedIteration[] }} props */
function Flanks({ iterations }) {
  const newest = newestOf(iterations);
  if (newest.length < 2) return null;
  return html`<ul class="flank-statuses" aria-label=${t.flanks}>
    ${newest.map(
      (
        one,
      ) => html`<li key=${one.number}>${one.flank ? t[one.flank] : ABSENT}${one.tooth && html` <span translate="no">${one.tooth}</span>`}:${" "}
        ${h(Decision, { decision: one.decision })} <span class="quiet">${common.iteration(one.number)}</span></li>`,
    )}
  </ul>`;
}

/** @param {{ job: Job }} props */
function Unmeasured({ job }) {
  const action = measureAction(job.id);
  return h(Empty, { children: action ? t.nextMeasure : `${t.nextMeasure} ${t.nextMeasureApi}`, action });
}

/** @param {{ job: Job, last: TracedIteration | undefined }} props */
function NextStep({ job, last }) {
  const { text, out = [], links } = nextStep(job, last);
  const there = links.flatMap(([label, to]) => (to ? [{ label, to }] : []));
  return html`<section class="panel next" aria-labelledby="next">
    <h2 id="next">${t.next}</h2>
    <p class="next-text">${text}</p>
    ${
      out.length > 0 &&
      html`<ul class="next-figures">${out.map(
        ({ name, symbol, figure: { value, std_error, conformity } }) => html`<li key=${name}>
          ${h(Within, { within: false })} ${h(GearSymbol, { name: symbol })}${" "}
          <b translate="no">${fmt.value.deviation(value, "µm", std_error)} µm</b>${" "}
          ${conformity && html`<span class="quiet" translate="no">(${limitText(conformity.limits_um)})</span>`}
        </li>`,
      )}</ul>`
    }
    ${
      there.length > 0 &&
      html`<div class="actions">
        ${there.map(({ label, to }, i) => html`<a key=${to} class=${i === 0 ? "button primary" : "button"} href=${to}>${label}</a>`)}
      </div>`
    }
  </section>`;
}

/** @param {Job} job @param {TracedIteration | undefined} last @returns {{ text: string, out?: ReturnType<typeof figureRows>, links: [string, string | undefined][] }} */
function nextStep(job, last) {
  const at = { job_id: job.id, number: last?.number ?? 0 };
  const measure = toMeasure(job.id);
  const iteration = (/** @type {string} */ view) => hrefIf(`/jobs/{job_id}/iterations/{number}${view}`, at);
  if (!last) return { text: t.nextMeasure, links: [] };
  if (last.decision === "accepted")
    return { text: t.nextAccepted(last.number), links: [[t.toReport, hrefIf("/jobs/{job_id}/report", at)]] };
  if (last.decision === "rejected") return { text: t.nextRejected(last.number), links: [] };
  if (last.decision === "remachine") {
    return {
      text: t.nextCorrect(last.number),
      links: [
        [t.toCorrection, iteration("/correction")],
        [t.toMeasure, measure],
      ],
    };
  }
  const rows = figureRows(chosenFit(last)?.figures);
  const out = rows.filter(({ figure }) => figure.within === false);
  const map = /** @type {[string, string | undefined]} */ ([t.toDecide, iteration("")]);
  if (out.length === 0) {
    const within = rows.some(({ figure }) => figure.within);
    return { text: within ? t.nextWithin(last.number) : t.nextDecide(last.number), links: [map] };
  }
  return { text: t.nextOutside(last.number), out, links: [[t.toCorrection, iteration("/correction")], map] };
}

/** @param {{ job: Job, iterations: readonly TracedIteration[] }} props */
function Iterations({ job, iterations }) {
  const f = fmt.value;
  const data = (/** @type {string | undefined} */ text) => (text ? html`<span translate="no">${text}</span>` : ABSENT);
  const unitOf = (/** @type {TracedIteration} */ one) => heightUnit(one.axes);
  const fit = chosenFit;
  const flank = (/** @type {TracedIteration} */ one) => {
    if (!one.flank && !one.tooth) return ABSENT;
    return html`${one.flank && t[one.flank]} ${one.tooth && data(one.tooth)}`;
  };
  const condition = (/** @type {TracedIteration} */ one) => {
    const { condition: before, regularized_condition: after } = fit(one) ?? {};
    return data(after == null ? f.condition(before) : `${f.condition(before)} → ${f.condition(after)}`);
  };
  const height = (/** @type {TracedIteration} */ one, /** @type {number | null | undefined} */ value) => {
    if (value == null) return ABSENT;
    const unit = unitOf(one);
    const written = unit === "mm" ? f.mm(value) : f.three(value);
    return html`<span translate="no">${written} ${unit ?? ""}</span>${!unit && html`<span class="quiet">${common.callersUnit}</span>`}`;
  };
  return html`<section class="panel" aria-labelledby="iterations">
    <h2 id="iterations">${t.iterations}</h2>
    ${h(Flanks, { iterations })}
    ${table({
      caption: t.iterations,
      hideCaption: true,
      csvName: `${job.name} iterations`,
      stacked: true,
      rows: iterations,
      rowKey: ({ number }) => number,
      columns: /** @type {import("../components/table.js").Column<TracedIteration>[]} */ ([
        {
          key: "number",
          header: t.number,
          rowHeader: true,
          cell: (one) => numberLink(job, one.number),
          csv: (one) => one.number,
        },
        { key: "flank", header: t.flank, cell: flank, csv: (one) => one.flank && t[one.flank] },
        { key: "tooth", header: t.tooth, csv: (one) => one.tooth },
        {
          key: "measured",
          header: t.measured,
          cell: (one) => html`<time translate="no">${f.time(one.measured_at ?? one.created_at)}</time>`,
          csv: (one) => one.measured_at ?? one.created_at,
        },
        {
          key: "fits",
          header: t.fits,
          numeric: true,
          minor: true,
          cell: (one) => f.count(one.fits.length + (one.earlier?.fits ?? 0)),
          csv: (one) => one.fits.length + (one.earlier?.fits ?? 0),
        },
        {
          key: "criterion",
          header: t.criterion,
          minor: true,
          cell: (one) => data(fit(one)?.criterion),
          csv: (one) => fit(one)?.criterion,
        },
        {
          key: "lambda",
          header: t.lambda,
          numeric: true,
          cell: (one) => data(f.three(fit(one)?.lambda_star)),
          csv: (one) => fit(one)?.lambda_star,
        },
        {
          key: "rms",
          header: t.rms,
          numeric: true,
          cell: (one) => height(one, fit(one)?.rms),
          csv: (one) => fit(one)?.rms,
        },
        {
          key: "condition",
          header: t.condition,
          numeric: true,
          minor: true,
          cell: condition,
          csv: (one) => fit(one)?.condition,
        },
        { key: "after", header: t.conditionAfter, csv: (one) => fit(one)?.regularized_condition },
        {
          key: "decision",
          header: t.decision,
          cell: (one) => h(Decision, { decision: one.decision }),
          csv: ({ decision }) => decision && common[decision],
        },
      ]),
    })}
  </section>`;
}

/** @param {{ job: Job, iterations: readonly TracedIteration[] }} props */
function Figures({ job, iterations }) {
  const of = job.requirements?.tolerance_limits?.class;
  const tolerances = useTolerances(job.gear, String(of ?? ""));
  return html`<section class="panel" aria-labelledby="flank-figures">
    <h2 id="flank-figures">${requirementText.figuresOfFit}</h2>
    ${h(FiguresOfIterations, {
      csvName: `${job.name} figures`,
      required: (name, flank) => requiredLimits(job.requirements, flank, name, tolerances.data?.rounded),
      rows: iterations.map((one) => ({
        number: one.number,
        link: numberLink(job, one.number),
        flank: one.flank ?? undefined,
        figures: chosenFit(one)?.figures,
      })),
    })}
  </section>`;
}

/** @param {Job} job @param {number} number */
function numberLink(job, number) {
  const to = hrefIf("/jobs/{job_id}/iterations/{number}", { job_id: job.id, number });
  const text = html`<span class="visually-hidden">${t.number}</span> ${number}`;
  return to ? html`<a href=${to}>${text}</a>` : number;
}

/** @param {{ decision: TracedIteration["decision"] }} props */
function Decision({ decision }) {
  if (!decision) return h(Badge, { kind: "news", children: t.undecided });
  const kind = /** @type {const} */ ({ accepted: "good", remachine: "warn", rejected: "bad" })[decision];
  return h(Badge, { kind, children: common[decision] });
}

/** @param {{ job: Job }} props */
function AboutJob({ job }) {
  const data = (/** @type {string} */ text) => html`<span translate="no">${text}</span>`;
  const gear = gearInShort(job.gear);
  return html`<section class="panel" aria-labelledby="about-job">
    <h2 id="about-job">${t.about}</h2>
    ${h(Facts, {
      columns: true,
      items: [
        { name: t.gear, value: gear ? data(gear) : t.noGear },
        { name: t.tags, value: h(Tags, { tags: job.tags }) },
        { name: t.created, value: data(fmt.value.time(job.created_at)) },
        { name: t.changed, value: data(fmt.value.time(job.updated_at)) },
        { name: t.id, value: html`<code translate="no">${job.id}</code>` },
      ],
    })}
  </section>`;
}

/** @param {{ job: Job, resource: JobResource, empty: boolean }} props */
function Actions({ job, resource, empty }) {
  const [open, setOpen] = useState(/** @type {"edit" | "delete" | null} */ (null));
  const close = () => setOpen(null);
  return html`<button type="button" class="button" onClick=${() => setOpen("edit")}>${common.edit}</button>
    ${empty && html`<button type="button" class="button" onClick=${() => setOpen("delete")}>${common.delete}</button>`}
    ${
      open === "edit" &&
      h(EditJob, {
        version: { data: job, etag: resource.etag },
        onClose: close,
        onSaved: ({ data, etag }) => {
          resource.put(data, etag);
          close();
        },
      })
    }
    ${open === "delete" && h(DeleteJob, { job, etag: resource.etag, onClose: close })}`;
}

/** Deletes the job; the server refuses if it has iterations. @param {{ job: Job, etag: string | undefined, onClose: () => void }} props */
function DeleteJob({ job, etag, onClose }) {
  const [error, setError] = useState(/** @type {unknown} */ (undefined));
  const remove = async () => {
    try {
      const header = etag === undefined ? {} : { "If-Match": etag };
      await answer(api.DELETE("/v1/jobs/{job_id}", { params: { path: { job_id: job.id }, header } }));
      notify(t.deleted);
      navigate(href("/jobs"));
    } catch (failed) {
      setError(failed);
    }
  };
  return h(Dialog, {
    title: t.deleteJob,
    onClose,
    children: html`<p><b translate="no">${job.name}</b></p>
      <p>${t.deleteText}</p>
      ${error !== undefined && h(Failure, { error })}
      <div class="actions">
        <button type="button" class="button danger" onClick=${remove}>${common.delete}</button>
        <button type="button" class="button" onClick=${onClose}>${common.cancel}</button>
      </div>`,
  });
}
