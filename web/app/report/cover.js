// The first page of a report, complete in itself: measurement, results, decision, signature.

import { Badge } from "../components/figure.js";
import { DecisionBadge } from "../components/decision.js";
import { GearSymbol } from "../components/symbol.js";
import { t as common } from "../i18n/common.js";
import { fmt } from "../i18n/i18n.js";
import { t } from "../i18n/report.js";
import { ABSENT } from "../lib/format.js";
import { html, h } from "../../vendor/ui.js";
import { CoverFigures } from "./cover_figures.js";
import { SmallMaps } from "./maps.js";
import { endsOf } from "./pairs.js";

/** @typedef {import("./data.js").ReportData} ReportData */
/** @typedef {import("./data.js").Job} Job */

/** @param {{ job: Job, data: readonly ReportData[] }} props */
export function Cover({ job, data }) {
  const decided = data.map(({ iteration }) => iteration.decision).at(-1);
  const ends = endsOf(data);
  return html`<section class="report-cover" aria-labelledby="report-title">
    <header class="report-head">
      <div>
        <p class="report-kind">${t.heading}</p>
        <h2 id="report-title" translate="no">${job.name}</h2>
      </div>
      ${decided && h(DecisionBadge, { decision: decided })}
    </header>
    ${h(JobFacts, { job })}
    ${h(Measurements, { data: ends })}
    ${h(SmallMaps, { data: ends, flipU: job.gear?.internal === true })}
    ${h(CoverFigures, { data: ends })}
    ${h(Decisions, { data: ends })}
    ${h(Signature, null)}
  </section>`;
}

/** @param {{ job: Job }} props */
function JobFacts({ job }) {
  const { value } = fmt;
  const { gear } = job;
  const number = (/** @type {number} */ of) => value.input(of).replace("-", "−");
  const mm = (/** @type {number | null | undefined} */ length) =>
    length == null ? undefined : `${number(length)}\u202fmm`;
  const degrees = (/** @type {number | null | undefined} */ angle) => (angle == null ? undefined : `${number(angle)}°`);
  /** @type {readonly [string, string | undefined][]} */
  const signs = gear
    ? [
        ["z", `${gear.internal ? "−" : ""}${gear.teeth}`],
        ["mₙ", mm(gear.normal_module_mm)],
        ["αₙ", degrees(gear.normal_pressure_angle_deg)],
        ["β", degrees(gear.helix_angle_deg)],
        ["x", gear.profile_shift_coefficient == null ? undefined : number(gear.profile_shift_coefficient)],
        ["b", mm(gear.face_width_mm)],
        ["dₐ", mm(gear.tip_diameter_mm)],
        ["d_f", mm(gear.root_diameter_mm)],
      ]
    : [];
  const fact = (/** @type {string} */ name, /** @type {string | null | undefined} */ text) =>
    html`<div key=${name}><dt>${name}</dt><dd translate="no" class="one-line">${text || ABSENT}</dd></div>`;
  return html`<dl class="report-facts">
    ${fact(t.part, job.part_number)}${fact(t.serial, job.serial_number)}${fact(t.machine, job.machine)}
    <div class="wide">
      <dt>${t.gear}</dt>
      <dd>${
        gear
          ? html`<span class="report-gear" translate="no">
              ${signs.map(([sign, text]) => text && html`<span key=${sign}>${h(GearSymbol, { name: sign })} ${text}</span>`)}
            </span>`
          : t.noGear
      }</dd>
    </div>
  </dl>`;
}

/** @param {{ data: readonly ReportData[] }} props */
function Measurements({ data }) {
  const { value } = fmt;
  const verbatim = (/** @type {string | null | undefined} */ text) =>
    html`<span class="one-line" translate="no">${text || ABSENT}</span>`;
  return html`<table class="report-table">
    <caption class="visually-hidden">${t.measurement}</caption>
    <thead><tr>${[t.iteration, t.measured, t.flank, t.tooth, t.instrument, t.operator].map((name) => html`<th key=${name} scope="col">${name}</th>`)}
      <th scope="col" class="numeric">${t.nodes}</th></tr></thead>
    <tbody>
      ${data.map(
        ({ iteration: one }) => html`<tr key=${one.number}>
          <th scope="row" translate="no">${one.number}</th>
          <td>${verbatim(value.time(one.measured_at ?? one.created_at))}</td>
          <td>${one.flank ? t[one.flank] : ABSENT}</td>
          <td>${verbatim(one.tooth)}</td>
          <td>${verbatim(one.instrument)}</td>
          <td>${verbatim(one.operator)}</td>
          <td class="numeric">${verbatim(value.count(one.node_count))}</td>
        </tr>`,
      )}
    </tbody>
  </table>`;
}

/** @param {{ data: readonly ReportData[] }} props */
function Decisions({ data }) {
  const all = data.map(({ iteration, traced }) => ({ number: iteration.number, decided: traced.decisions.at(-1) }));
  return html`<section class="report-decision" aria-labelledby="report-decision">
    <h3 id="report-decision">${t.decision}</h3>
    ${all.map(
      ({ number, decided }) => html`<p key=${number} class="decision-line">
        <span>${common.iteration(number)}</span>
        ${
          decided
            ? html`${h(DecisionBadge, { decision: decided.decision })}
              <span class="clamped" translate="no">${decided.reason ?? ABSENT}</span>
              <time translate="no">${fmt.value.time(decided.created_at)}</time>`
            : html`${h(Badge, { kind: "plain", children: t.undecided })}`
        }
      </p>`,
    )}
  </section>`;
}

/** Lines for handwriting. */
function Signature() {
  return html`<div class="report-signature">
    ${[t.date, t.name, t.signature].map((name) => html`<div key=${name}><span>${name}</span></div>`)}
  </div>`;
}
