// Corrections in a report: the changes, the prediction, the result.

import { CorrectionMaps } from "../components/correction_maps.js";
import { Answer, Indistinguishable, Changes, Figures } from "../components/correction_result.js";
import { t as common } from "../i18n/common.js";
import { t as words } from "../i18n/correction.js";
import { t } from "../i18n/report.js";
import { h, html } from "../../vendor/ui.js";

/** @typedef {import("./data.js").ReportData} ReportData */

/** @param {{ data: readonly ReportData[] }} props */
export function Corrections({ data }) {
  const all = data.flatMap((one) => (one.correction ? [{ data: one, kept: one.correction }] : []));
  if (all.length === 0) return html`<p>${t.noCorrection}</p>`;
  return html`${all.map(({ data: { iteration, nodes }, kept }) => {
    const { answer, not_compared: refused, result } = kept;
    return html`<div key=${kept.id} class="report-of">
      <div class="keep"><h3>${t.correctionOf(iteration.number)}</h3>
        <p class="quiet">${words.changesAbout} ${words.errorAbout}</p>
        ${h(Changes, { result, tools: null, of: common.iteration(iteration.number) })}</div>
      ${h(Indistinguishable, { result })}
      <div class="keep"><h3>${answer ? t.answeredBy(answer.iteration) : words.answered}</h3>
        ${answer ? h(Answer, { answer, entered: Boolean(kept.applied) }) : refused ? html`<p>${words.notCompared} <span lang="en">${refused}</span></p>` : html`<p>${t.notAnswered}</p>`}</div>
      <div class="keep"><h3>${answer ? t.figuresOfCorrection : words.figuresBefore}</h3>
        <p class="quiet">${result.figures ? words.figuresAbout : words.noFigures}</p>
        ${h(Figures, { kept, of: common.iteration(iteration.number) })}</div>
      <div class="keep"><h3>${t.mapsOfCorrection}</h3>${h(CorrectionMaps, { nodes, axes: iteration.axes, kept, paper: true })}</div>
    </div>`;
  })}`;
}
