// The end of a report: events in their order, warnings, and how everything was computed.

import { Criterion } from "../components/criterion.js";
import { DecisionBadge } from "../components/decision.js";
import { t as common } from "../i18n/common.js";
import { fmt } from "../i18n/i18n.js";
import { t } from "../i18n/report.js";
import { ABSENT } from "../lib/format.js";
import { entriesOf } from "../trace/entries.js";
import { WarningList } from "../components/warnings.js";
import { h, html } from "../../vendor/ui.js";

/** @typedef {import("./data.js").ReportData} ReportData */
/** @typedef {import("../trace/entries.js").Entry} Entry */
/** @typedef {import("../api/client.js").Schema<"Decision">} DecisionName */

/** The whole trace of the job, whatever iterations the report has: no event is left out. @param {{ iterations: readonly import("../api/job.js").TracedIteration[] }} props */
export function Story({ iterations }) {
  const cut = iterations.some(({ earlier }) => earlier);
  return html`${cut && html`<p class="quiet">${t.earlierEntries}</p>`}
    <table class="report-table report-story long">
      <caption class="visually-hidden">${t.trace}</caption>
      <thead><tr><th scope="col">${t.time}</th><th scope="col" class="numeric">${t.iteration}</th><th scope="col">${t.event}</th>
        <th scope="col">${t.what}</th><th scope="col">${t.reason}</th></tr></thead>
      <tbody>
        ${entriesOf(iterations).map(
          (entry) => html`<tr key=${entry.id}>
            <td><time translate="no">${fmt.value.time(entry.time)}</time></td>
            <td class="numeric" translate="no">${entry.iteration}</td>
            <td>${t[`ev_${entry.kind}`]}</td>
            <td>${whatOf(entry)}</td>
            <td translate="no" class="free-text">${reasonOf(entry)}</td>
          </tr>`,
        )}
      </tbody>
    </table>`;
}

/** @param {Entry} entry */
function whatOf(entry) {
  if (entry.kind === "measured")
    return entry.correctionOf === undefined ? ABSENT : t.afterCorrection(entry.correctionOf);
  if (entry.kind === "record") {
    return html`${t[`record_${entry.record.kind}`]} <code translate="no">${entry.record.method}</code>`;
  }
  if (entry.kind === "decision") return h(DecisionBadge, { decision: /** @type {DecisionName} */ (entry.decision) });
  const { fit } = entry;
  if (!fit) return t.earlierFit;
  return html`${h(Criterion, { name: fit.criterion })} <span translate="no">λ* ${fmt.value.three(fit.lambda_star)}</span>`;
}

/** @param {Entry} entry */
function reasonOf(entry) {
  if (entry.kind === "fit") return entry.fit.reason ?? "";
  return entry.kind === "choice" || entry.kind === "decision" ? (entry.reason ?? "") : "";
}

/** Warnings of the server. @param {{ data: readonly ReportData[] }} props */
export function Warnings({ data }) {
  const lists = data.flatMap(({ iteration: { number }, fit, evaluated, pitched, correction }) => [
    { name: t.ofFit(number), warnings: fit?.result.warnings ?? [] },
    { name: t.ofEvaluation(number), warnings: evaluated?.result.warnings ?? [] },
    { name: t.ofPitch(number), warnings: pitched?.result.warnings ?? [] },
    { name: t.ofCorrection(number), warnings: correction?.result.warnings ?? [] },
  ]);
  const there = lists.filter(({ warnings }) => warnings.length > 0);
  if (there.length === 0) return html`<p>${t.noWarnings}</p>`;
  return html`${there.map(
    ({ name, warnings }) => html`<div key=${name} class="report-warnings">
      <h3>${name}</h3>
      ${h(WarningList, { warnings })}
    </div>`,
  )}`;
}

/** @param {{ jobId: string, data: readonly ReportData[] }} props */
export function Origin({ jobId, data }) {
  const { value } = fmt;
  return html`<p class="quiet">${t.digestAbout}</p>
    ${data.map(({ iteration, fit }) => {
      /** @type {[string, string][]} */
      const facts = [
        [t.jobId, jobId],
        ...(fit
          ? /** @type {[string, string][]} */ ([
              [t.fitId, fit.id],
              [t.fittedAt, value.time(fit.created_at)],
              [t.engine, fit.result.provenance.engine],
              [t.digest, fit.result.provenance.input_sha256],
              [t.arithmetic, fit.result.numerics.arithmetic],
              [t.digits, value.fixed(fit.result.numerics.correct_digits, 1)],
            ])
          : []),
      ];
      return html`<div key=${iteration.number} class="keep">
        <h3>${common.iteration(iteration.number)}</h3>
        ${!fit && html`<p>${t.noFit}</p>`}
        <dl class="report-origin">${facts.map(([name, text]) => html`<div key=${name}><dt>${name}</dt><dd translate="no">${text}</dd></div>`)}</dl>
      </div>`;
    })}`;
}
