// Evaluated traces of an iteration, as on printed tester sheets.

import { may } from "../api/key.js";
import { useRecord, useRecords } from "../api/records.js";
import { useTolerances } from "../api/tolerances.js";
import { Dfq } from "../components/dfq.js";
import { EvaluationForm } from "../components/evaluation_form.js";
import { EvaluationSheet } from "../components/evaluation_sheet.js";
import { EvaluationTable, symbolsOf } from "../components/evaluation_table.js";
import { Facts } from "../components/figure.js";
import { PitchSheet } from "../components/pitch_sheet.js";
import { SelectField } from "../components/form.js";
import { JobPage, useNews } from "../components/job_page.js";
import { Empty, loaded, measureAction } from "../components/states.js";
import { t } from "../i18n/evaluation.js";
import { fmt } from "../i18n/i18n.js";
import { t as pitchText } from "../i18n/pitch.js";
import { CLASSES } from "../lib/requirements.js";
import { query, setQuery } from "../navigation.js";
import { WarningList } from "../components/warnings.js";
import { h, html } from "../../vendor/ui.js";

/** @typedef {import("../api/client.js").Schema<"Job">} Job */
/** @typedef {import("../api/client.js").Schema<"JobRecord">} JobRecord */
/** @typedef {import("../api/client.js").Schema<"RecordSummary">} RecordSummary */
/** @typedef {import("../api/client.js").Schema<"GearEvaluation">} GearEvaluation */
/** @typedef {import("../api/client.js").Schema<"GearTolerances">} GearTolerances */
/** @typedef {import("../api/client.js").Schema<"EvaluateGear">} EvaluateGear */

export const styles = ["evaluation"];

/** @param {{ params: Record<string, string> }} props */
export default function EvaluationPage({ params }) {
  const [jobId, number] = [params["job_id"] ?? "", Number(params["number"])];
  return h(JobPage, {
    jobId,
    view: t.title,
    number,
    children: (job, { news }) => h(Evaluations, { job, number, news }),
  });
}

/** @param {{ job: Job, number: number, news: number }} props */
function Evaluations({ job, number, news }) {
  const records = useRecords(job.id, number);
  useNews(news, [records]);
  const made = records.data?.filter(({ kind }) => kind === "evaluation") ?? [];
  const id = query.value.get("record") ?? made.at(-1)?.id;
  const record = useRecord(job.id, number, records.data ? id : undefined);
  const action = measureAction(job.id);
  const choice =
    made.length > 1 &&
    h(SelectField, {
      label: t.record,
      required: true,
      value: id ?? "",
      onChange: (value) => setQuery({ record: value }, { step: true }),
      options: made.map((one) => ({
        value: one.id,
        label: html`<span translate="no">${fmt.value.time(one.created_at)}, ${fmt.value.clock(one.created_at)}</span>`,
      })),
    });
  const pitches = records.data?.filter(({ kind }) => kind === "pitch") ?? [];
  return loaded({
    resource: records,
    children: () =>
      html`${
        id === undefined
          ? h(Empty, { children: pitches.length > 0 ? t.noTraces : t.none, action })
          : loaded({
              resource: record,
              lines: 12,
              children: (data) =>
                h(Evaluation, {
                  key: id,
                  job,
                  number,
                  record: /** @type {JobRecord} */ (data),
                  choice,
                  onDone: (next) => {
                    setQuery({ record: next }, { step: true });
                    records.reload();
                    scrollTo(0, 0);
                  },
                }),
            })
      }${(id === undefined || record.data || record.error) && pitches.length > 0 && h(Pitch, { job, number, made: pitches })}${
        record.data && pitches.length === 0 && h(Empty, { children: pitchText.none, action })
      }`,
  });
}

/** @param {{ job: Job, number: number, record: JobRecord, choice: import("../../vendor/ui.js").ComponentChildren, onDone: (id: string) => void }} props */
function Evaluation({ job, number, record, choice, onDone }) {
  const evaluation = /** @type {GearEvaluation} */ (/** @type {unknown} */ (record.result));
  const request = /** @type {Partial<EvaluateGear>} */ (record.request);
  const traces = Array.isArray(request.traces) ? request.traces : [];
  const settings = evaluation.evaluation;
  const gear = request.gear ?? record.gear ?? job.gear ?? undefined;
  const bands = settings.k_bands ?? [];
  const picked = query.value.get("class") ?? "";
  const of = picked || String(settings.tolerance_limits?.class ?? "");
  const wanted = gear && CLASSES.includes(of) && may("compute") ? of : undefined;
  const tolerances = useTolerances(gear, of);
  const kinds = /** @type {const} */ (["profile", "helix"]).filter((kind) =>
    evaluation.traces.some((trace) => trace.kind === kind),
  );
  const without = evaluation.traces.some((trace) => trace.slope_um !== undefined && !trace.mean_line_um);
  return html`
    <section class="panel" aria-labelledby="about">
      <header><h2 id="about">${t.record}</h2>
        ${h(Dfq, { jobId: job.id, number, record: record.id, name: `${job.name} ${number} ${t.title}` })}</header>
      ${h(Facts, {
        items: [
          { name: t.made, value: data(fmt.value.time(record.created_at)) },
          { name: t.overall, value: data(evaluation.coarser_than_11 ? ">11" : fmt.value.count(evaluation.class)) },
          { name: t.signOf, value: t[settings.sign ?? "din"] },
          { name: t.against, value: t[`against_${settings.against ?? "involute"}`] },
          { name: t.level, value: data(`${fmt.value.fixed(100 * (settings.level ?? 0.95), 0)}\u202f%`) },
        ],
      })}
      <div class="fields">
        ${h(SelectField, {
          label: t.classOfBand,
          required: true,
          value: bands.length > 0 ? picked : of,
          onChange: (value) => setQuery({ class: value || undefined }),
          options: [
            { value: "", label: bands.length > 0 ? t.asRequired : t.noClass },
            ...CLASSES.map((value) => ({ value, label: html`<span translate="no">${value}</span>` })),
          ],
        })}
        ${choice}
      </div>
      ${!gear && html`<p>${t.noTolerance}</p>`}${gear && !wanted && bands.length === 0 && html`<p class="quiet">${t.noBand}</p>`}
      ${tolerances.error !== undefined && loaded({ resource: tolerances, children: () => null })}
      ${traces.length === 0 && html`<p class="note">${t.imported}</p>`}
      ${traces.length > 0 && html`<p class="hint">${t.drawn}${without && ` ${t.noMeanLine}`}${bands.length > 0 && !picked && ` ${t.requiredBands}`}</p>`}
    </section>
    ${kinds.map((kind) => {
      const known = wanted ? tolerances.data : undefined;
      const values = settings.tolerances === "unrounded" ? known?.unrounded : known?.rounded;
      const required = !picked && evaluation.traces.some((one) => one.kind === kind && one.k_bands?.length);
      const band = values?.[`${kind}_total_um`] ?? undefined;
      return html`<section key=${kind} class="panel" aria-labelledby=${kind}>
        <header><h2 id=${kind}>${t[kind]}</h2></header>
        ${traces.length > 0 && h(EvaluationSheet, { kind, traces, evaluation, gear, band, required })}
        ${wanted && !required && tolerances.loading && !known && html`<p class="hint" aria-hidden="true">\u00a0</p>`}
        ${band !== undefined && !required && known && html`<p class="hint">${t.band(fmt.value.um(band), known.class, symbolsOf(kind).total.replace("_", ""))}</p>`}
        ${h(EvaluationTable, { kind, evaluation, tolerances: known, csvName: `${job.name} ${number} ${t[kind]}` })}
      </section>`;
    })}
    ${
      evaluation.warnings.length > 0 &&
      html`<section class="panel" aria-labelledby="warnings">
        <h2 id="warnings">${t.warnings}</h2>
        ${h(WarningList, { warnings: evaluation.warnings })}
      </section>`
    }
    ${
      traces.length > 0 &&
      may("measure") &&
      html`<details class="panel another"><summary><h2>${t.again}</h2></summary>
        ${h(EvaluationForm, { jobId: job.id, number, record: record.id, request: /** @type {EvaluateGear} */ (request), settings, designed: job.requirements?.design !== undefined, onDone })}
      </details>`
    }`;
}

/** Pitches and run-out, as stored. @param {{ job: Job, number: number, made: readonly RecordSummary[] }} props */
function Pitch({ job, number, made }) {
  const id = query.value.get("pitch") ?? made.at(-1)?.id;
  const record = useRecord(job.id, number, id);
  return html`<section class="panel" aria-labelledby="pitch">
    <header><h2 id="pitch">${pitchText.title}</h2>
      ${id && h(Dfq, { jobId: job.id, number, record: id, name: `${job.name} ${number} ${pitchText.title}` })}</header>
    ${
      made.length > 1 &&
      html`<div class="fields">${h(SelectField, {
        label: pitchText.record,
        required: true,
        value: id ?? "",
        onChange: (value) => setQuery({ pitch: value }, { step: true }),
        options: made.map((one) => ({
          value: one.id,
          label: data(`${fmt.value.time(one.created_at)}, ${fmt.value.clock(one.created_at)}`),
        })),
      })}</div>`
    }
    ${loaded({
      resource: record,
      lines: 8,
      children: (whole) => h(PitchWithTolerances, { key: id, job, number, record: /** @type {JobRecord} */ (whole) }),
    })}
  </section>`;
}

/** @param {{ job: Job, number: number, record: JobRecord }} props */
function PitchWithTolerances({ job, number, record }) {
  const request = /** @type {{ gear?: Job["gear"] }} */ (record.request);
  const gear = request.gear ?? record.gear ?? job.gear ?? undefined;
  const of = query.value.get("class") || String(job.requirements?.tolerance_limits?.class ?? "");
  const tolerances = useTolerances(gear, of);
  return h(PitchSheet, {
    pitch: /** @type {import("../api/client.js").Schema<"PitchEvaluation">} */ (/** @type {unknown} */ (record.result)),
    tolerances: tolerances.data,
    csvName: `${job.name} ${number} ${pitchText.title}`,
  });
}

/** @param {string} text */
const data = (text) => html`<span translate="no">${text}</span>`;
