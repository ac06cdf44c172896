// The choice of λ* and the spectrum in a report: the choices of the criteria, the chosen fit, and
// the reason.

import { Chart } from "../charts/chart.js";
import { Dots, Line, Rule } from "../charts/marks.js";
import { Criterion } from "../components/criterion.js";
import { Badge } from "../components/figure.js";
import { table } from "../components/table.js";
import { t as common } from "../i18n/common.js";
import de from "../i18n/de/lambda.js";
import deStatistics from "../i18n/de/statistics.js";
import en from "../i18n/en/lambda.js";
import enStatistics from "../i18n/en/statistics.js";
import { fmt, texts } from "../i18n/i18n.js";
import { t } from "../i18n/report.js";
import { heightUnit } from "../lib/units.js";
import { choiceColumns } from "../regularization/choices.js";
import { symbolOf } from "../regularization/selection.js";
import { raisedIn } from "../lib/spectrum.js";
import { h, html } from "../../vendor/ui.js";

/** @typedef {import("./data.js").ReportData} ReportData */
/** @typedef {import("./data.js").IterationFit} IterationFit */

const words = texts({ en, de });
const spectral = texts({ en: enStatistics, de: deStatistics });

/** @param {{ data: readonly ReportData[] }} props */
export function Choices({ data }) {
  return html`${data.map(
    (one) => html`<div key=${one.iteration.number} class="report-of">
      <div class="keep"><h3>${common.iteration(one.iteration.number)}</h3>${h(Why, { data: one })}
      ${one.fit && h(ChoiceTable, { number: one.iteration.number, fit: one.fit, unit: heightUnit(one.iteration.axes) })}</div>
      ${one.fit && h(Curve, { fit: one.fit, symbol: symbolOf(one.fit.spec) })}
    </div>`,
  )}`;
}

/** The chosen fit, its time and its reason. @param {{ data: ReportData }} props */
function Why({ data: { traced, fit } }) {
  if (!fit) return html`<p>${t.noFit}</p>`;
  const choice = traced.choices.findLast(({ fit_id }) => fit_id === fit.id);
  const { regularization } = fit.result;
  const reason = choice?.reason ?? fit.reason;
  return html`<p>
    ${h(Criterion, { name: regularization.criterion })}
    ${regularization.lambda_star !== undefined && html`, <span translate="no">${symbolOf(fit.spec)} = ${fmt.value.three(regularization.lambda_star)}</span>`}.
    ${choice && ` ${t.chosenSince(fmt.value.time(choice.created_at))}`}
    ${" "}${reason ? html`${t.choiceReason}: <span translate="no">${reason}</span>` : t.noReason}
  </p>`;
}

/** @param {{ number: number, fit: IterationFit, unit: string | undefined }} props */
function ChoiceTable({ number, fit, unit }) {
  const { regularization } = fit.result;
  if (regularization.choices.length === 0) return html`<p>${t.noChoices}</p>`;
  return table({
    caption: `${t.lambda}, ${common.iteration(number)}`,
    hideCaption: true,
    rows: regularization.choices,
    rowKey: ({ criterion }) => criterion,
    rowClass: ({ criterion }) => (criterion === regularization.criterion ? "chosen" : ""),
    columns: [
      ...choiceColumns(symbolOf(fit.spec), unit),
      {
        key: "chosen",
        header: t.wasChosen,
        cell: ({ criterion }) =>
          criterion === regularization.criterion && h(Badge, { kind: "good", children: t.chosen }),
      },
    ],
  });
}

/** The predicted error along λ*, with the choices. @param {{ fit: IterationFit, symbol: string }} props */
function Curve({ fit: { result }, symbol }) {
  const points = (result.lambda_curve ?? []).flatMap(({ lambda_star: x, predicted_mse: y }) =>
    typeof y === "number" && y > 0 ? [{ x, y }] : [],
  );
  const [first, last] = [points[0], points.at(-1)];
  if (!first || !last || points.length < 2) return null;
  const heights = points.map(({ y }) => y);
  const [low, high] = [Math.min(...heights), Math.max(...heights)];
  const { lambda_star: at, choices, criterion } = result.regularization;
  const chosenMse = choices.find((one) => one.criterion === criterion)?.predicted_mse;
  return h(Chart, {
    name: t.curve,
    summary: t.curveSummary,
    x: { label: words.symbol(symbol), scale: "log", domain: [first.x, last.x] },
    y: { label: words.predictedMse, scale: "log", domain: [Math.max(low, high / 1e9), high * 1.3] },
    height: 210,
    children: (plot) => html`
      ${choices.map(({ criterion: name, lambda_star: x }) => (x !== undefined && x >= first.x && x <= last.x ? h(Rule, { key: name, plot, x }) : null))}
      ${h(Line, { plot, points })}
      ${at !== undefined && typeof chosenMse === "number" && h(Dots, { plot, points: [{ x: at, y: chosenMse }], sign: "square", series: "vermilion" })}`,
  });
}

/** Eigenvalues before and after. @param {{ data: readonly ReportData[] }} props */
export function Spectra({ data }) {
  return html`${data.map(({ iteration, fit }) =>
    fit
      ? h(Spectrum, { key: iteration.number, number: iteration.number, fit })
      : html`<p key=${iteration.number}>${common.iteration(iteration.number)}: ${t.noFit}</p>`,
  )}`;
}

/** @param {{ number: number, fit: IterationFit }} props */
function Spectrum({ number, fit: { result, spec } }) {
  const before = result.spectrum.eigenvalues;
  const after = result.spectrum.regularized.eigenvalues;
  const regularization = /** @type {{ condition_limit?: number }} */ (spec.regularization ?? {});
  const limit = regularization.condition_limit;
  const greatest = before.at(-1) ?? 0;
  const bound = limit && greatest > 0 ? greatest / limit : undefined;
  const positive = [...before, ...(after ?? [])].filter((value) => value > 0);
  const points = (/** @type {readonly number[]} */ values) => values.map((y, i) => ({ x: i + 1, y: y > 0 ? y : null }));
  const { value } = fmt;
  const raised = raisedIn(before, after);
  const summary = spectral.spectrumSummary(
    value.condition(result.spectrum.condition),
    value.condition(result.spectrum.regularized.condition),
    value.count(raised),
    value.count(before.length),
  );
  return h(Chart, {
    name: common.iteration(number),
    summary: `${summary} ${t.spectrumSummary}`,
    x: { label: spectral.direction, domain: [0.5, before.length + 0.5], ticks: Math.min(10, before.length) },
    y: {
      label: spectral.eigenvalue,
      scale: "log",
      domain: [Math.min(...positive, bound ?? greatest) / 2, Math.max(...positive) * 2],
    },
    height: 230,
    children: (plot) => html`
      ${bound !== undefined && h(Rule, { plot, y: bound, label: spectral.conditionLimit(value.count(limit)), kind: "limit" })}
      ${raised > 0 && raised < before.length && h(Rule, { plot, x: raised + 0.5, label: spectral.regularisedTo(value.count(raised)) })}
      ${after && h(Dots, { plot, points: points(after), series: "vermilion", sign: "square" })}
      ${h(Dots, { plot, points: points(before) })}`,
  });
}
