// Pitches and run-out in a report: bars, curves and their figures.

import { PitchSheet } from "../components/pitch_sheet.js";
import { t as common } from "../i18n/common.js";
import { fmt } from "../i18n/i18n.js";
import { t } from "../i18n/report.js";
import { h, html } from "../../vendor/ui.js";

/** @typedef {import("./data.js").ReportData} ReportData */

/** @param {{ data: readonly ReportData[] }} props */
export function Pitches({ data }) {
  const all = data.flatMap(({ iteration, pitched }) => (pitched ? [{ number: iteration.number, pitched }] : []));
  if (all.length === 0) return html`<p>${t.noPitch}</p>`;
  return html`${all.map(
    ({ number, pitched: { record, result } }) => html`<div key=${number} class="report-of">
      <h3>${t.evaluatedAt(number, fmt.value.time(record.created_at))}</h3>
      ${h(PitchSheet, { pitch: result, of: common.iteration(number) })}
    </div>`,
  )}`;
}
