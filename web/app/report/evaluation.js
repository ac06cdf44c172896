// Evaluated traces in a report: K-charts upright, and their figures.

import { Strip, StripLegend } from "../charts/strip.js";
import { EvaluationSheet } from "../components/evaluation_sheet.js";
import { EvaluationTable, symbolsOf } from "../components/evaluation_table.js";
import { GearSymbol } from "../components/symbol.js";
import { Conforms } from "../components/within.js";
import { t as common } from "../i18n/common.js";
import { fmt } from "../i18n/i18n.js";
import { t as words } from "../i18n/evaluation.js";
import { t } from "../i18n/report.js";
import { estimateOf } from "../lib/strip.js";
import { Fragment, h, html } from "../../vendor/ui.js";

/** @typedef {import("./data.js").ReportData} ReportData */
/** @typedef {import("./data.js").Evaluated} Evaluated */

/** @param {{ data: readonly ReportData[] }} props */
export function Evaluations({ data }) {
  const all = data.flatMap(({ iteration, evaluated }) => (evaluated ? [{ number: iteration.number, evaluated }] : []));
  if (all.length === 0) return html`<p>${t.noEvaluation}</p>`;
  return h(
    Fragment,
    null,
    h(Ruler, null),
    all.map(({ number, evaluated }) => h(OneEvaluation, { key: number, number, evaluated })),
  );
}

/** A bar of 100 mm, to check that the charts are printed to scale. */
function Ruler() {
  const marks = Array.from({ length: 11 }, (_, i) => `M${10 * i} 0V${i % 5 === 0 ? 3 : 2}`).join("");
  return html`<figure class="report-ruler">
    <svg width="104mm" height="4mm" viewBox="-2 -0.5 104 4" role="img" aria-label=${t.rulerName}>
      <path class="bar" d="M0 0H100" /><path d=${marks} />
    </svg>
    <figcaption class="hint">${t.ruler}</figcaption>
  </figure>`;
}

/** @param {{ number: number, evaluated: Evaluated }} props */
function OneEvaluation({ number, evaluated }) {
  const { record, result, request, gear, tolerances } = evaluated;
  const traces = Array.isArray(request.traces) ? request.traces : [];
  const settings = result.evaluation;
  const without = result.traces.some((trace) => trace.slope_um !== undefined && !trace.mean_line_um);
  const bands = settings.k_bands ?? [];
  const values = settings.tolerances === "unrounded" ? tolerances?.unrounded : tolerances?.rounded;
  const kinds = /** @type {const} */ (["profile", "helix"]).filter((kind) =>
    result.traces.some((trace) => trace.kind === kind),
  );
  return html`<div class="report-evaluation">
    <div class="keep">
      <h3>${t.evaluatedAt(number, fmt.value.time(record.created_at))}</h3>
      ${
        traces.length === 0
          ? html`<p>${t.noTraces}</p>`
          : html`<p class="quiet">${words.drawn}${without && ` ${words.noMeanLine}`}${bands.length > 0 && ` ${words.requiredBands}`}${!values && bands.length === 0 && ` ${t.noBand}`}</p>`
      }
    </div>
    ${kinds.map((kind) => {
      const band = values?.[`${kind}_total_um`] ?? undefined;
      const required = result.traces.some((one) => one.kind === kind && one.k_bands?.length);
      const symbol = symbolsOf(kind).total.replace("_", " ");
      return html`<div key=${kind} class="report-kind-of">
        <h4>${words[kind]}</h4>
        ${traces.length > 0 && h(EvaluationSheet, { kind, traces, evaluation: result, gear, band, required, paper: true })}
        ${band !== undefined && !required && tolerances && html`<p class="quiet">${words.band(fmt.value.um(band), tolerances.class, symbol)}</p>`}
        ${h(EvaluationTable, { kind, evaluation: result, tolerances, brief: true, of: common.iteration(number) })}
      </div>`;
    })}
    ${result.surfaces.length > 0 && h(Surfaces, { result, number })}
  </div>`;
}

const FIGURES = /** @type {const} */ ([
  ["profile_slope", "f_Hα"],
  ["helix_slope", "f_Hβ"],
  ["profile_crowning", "C_α"],
  ["helix_crowning", "C_β"],
  ["twist", "S"],
]);

/** Figures of the surfaces through the traces of each tooth flank, with limits if they are required. @param {{ result: Evaluated["result"], number: number }} props */
function Surfaces({ result, number }) {
  const { value } = fmt;
  const rows = result.surfaces.flatMap(({ tooth, flank, ...surface }) =>
    FIGURES.flatMap(([name, symbol]) => {
      const figure = surface[/** @type {const} */ (`${name}_um`)];
      return figure ? [{ key: `${tooth} ${flank} ${name}`, tooth, flank, name, symbol, figure }] : [];
    }),
  );
  if (rows.length === 0) return null;
  return html`<div>
    <h4>${t.surfaces}</h4>
    <table class="report-table long">
      <caption class="visually-hidden">${`${t.surfaces}, ${common.iteration(number)}`}</caption>
      <thead><tr><th scope="col">${t.tooth}</th><th scope="col">${t.flank}</th><th scope="col">${t.figure}</th>
        <th scope="col" class="numeric" translate="no">µm</th><th scope="col" class="numeric">${t.bound}</th><th scope="col">${t.drawn}</th>
        <th scope="col" class="numeric">${t.limits}</th><th scope="col">${t.conformity}</th></tr></thead>
      <tbody>${rows.map(
        ({
          key,
          tooth,
          flank,
          name,
          symbol,
          figure,
          figure: { value: of, std_error, bias_bound, conformity },
        }) => html`<tr key=${key}>
          <th scope="row" translate="no">${tooth}</th><td>${t[flank]}</td>
          <td>${h(GearSymbol, { name: symbol })} ${t[name]}</td>
          <td class="numeric" translate="no">${value.withError(of, std_error)}</td>
          <td class="numeric" translate="no">${value.significant(bias_bound, 2)}</td>
          <td>${h(Strip, { estimates: [estimateOf(figure)], limits: conformity?.limits_um, unit: "µm", paper: true })}</td>
          <td class="numeric" translate="no">${value.interval(conformity?.limits_um, 1)}</td>
          <td>${h(Conforms, { conformity })}</td>
        </tr>`,
      )}</tbody>
    </table>
    <p class="quiet">${h(StripLegend, { estimates: rows.map(({ figure }) => estimateOf(figure)), limited: rows.some(({ figure }) => figure.conformity) })}</p>
  </div>`;
}
