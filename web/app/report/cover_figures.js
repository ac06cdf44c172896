// The figures of the first page, before and after; absent ones have a reason.

import { Strip, StripLegend } from "../charts/strip.js";
import { GearSymbol } from "../components/symbol.js";
import { Decided, VERDICTS } from "../components/within.js";
import { t as common } from "../i18n/common.js";
import { fmt } from "../i18n/i18n.js";
import { t } from "../i18n/report.js";
import { t as words } from "../i18n/requirements.js";
import { ABSENT } from "../lib/format.js";
import { heightUnit } from "../lib/units.js";
import { h, html } from "../../vendor/ui.js";
import { coarsest, flankRows, heightsOf, traceRows } from "./figures.js";
import { nameOf } from "./maps.js";
import { isPair } from "./pairs.js";

/** @typedef {import("./data.js").ReportData} ReportData */
/** @typedef {import("./figures.js").Row} Row */
/** @typedef {import("./figures.js").Cell} Cell */
/** @typedef {import("../../vendor/ui.js").ComponentChildren} Children */

/** @param {{ data: readonly ReportData[] }} props the first and the last */
export function CoverFigures({ data }) {
  const notes = notesOf();
  const { rows: flank, source } = flankRows(data);
  const traces = traceRows(data);
  const numbers = (/** @type {readonly ReportData[]} */ some) =>
    some.map(({ iteration }) => iteration.number).join(", ");
  const without = data.filter((_, i) => flank.every(({ cells }) => cells[i] === undefined));
  const whyFigures = without.length > 0 ? notes.mark(t.whyFigures(numbers(without))) : null;
  const unmeasured = data.filter(({ evaluated }) => !evaluated);
  const whyClass = unmeasured.length > 0 ? notes.mark(t.whyClass(numbers(unmeasured))) : null;
  const listed = [...(without.length === data.length ? [] : flank), ...traces];
  const whyLimits = listed.some(({ limits }) => !limits) ? notes.mark(t.whyLimits) : null;
  const decided = listed.some(({ cells }) => cells.at(-1)?.conformity);
  const why = reasonsOf(listed);
  const dense = listed.length > 9 ? " dense" : "";
  const drawn = listed.some(({ cells }) => cells.some((cell) => cell?.error));
  const changes = isPair(data) && flank.some(({ change }) => change);
  const row = (/** @type {Row} */ one, /** @type {Children} */ why) => html`<tr key=${one.key}>
    <th scope="row">${h(GearSymbol, { name: one.symbol })} ${t[one.name]}${one.flank && `, ${t[one.flank]}`}</th>
    ${one.cells.map((cell, i) => html`<td key=${i} class="numeric">${figure(cell, why)}</td>`)}
    ${changes && html`<td class="numeric">${one.change ? verbatim(fmt.value.withError(one.change.value_um, one.change.std_error_um)) : ""}</td>`}
    ${drawn && html`<td>${h(Strip, { estimates: drawnOf(one), limits: one.limits && [one.limits.low, one.limits.high], unit: "µm", paper: true })}</td>`}
    <td class="numeric">${one.limits ? limitsOf(one.limits, one.cells) : absent(whyLimits)}</td>
    <td class="numeric">${classesOf(one.cells)}</td>
  </tr>`;
  const fact = (/** @type {string} */ name, /** @type {(one: ReportData) => Children} */ of) => html`<tr key=${name}>
    <th scope="row">${name}</th>
    ${data.map((one) => html`<td key=${one.iteration.number} class="numeric">${of(one)}</td>`)}
    ${changes && html`<td></td>`}${drawn && html`<td></td>`}<td></td><td></td>
  </tr>`;
  const [first, last] = data;
  const pair = isPair(data);
  return html`<div class="report-figures">
    <table class=${`report-table${dense}`}>
      <caption>${t.figures}</caption>
      <thead><tr>
        <th scope="col">${t.figure} <span class="unit" translate="no">µm</span></th>
        ${first && html`<th scope="col" class="numeric">${pair ? t.before(first.iteration.number) : nameOf(first)}</th>`}
        ${last && html`<th scope="col" class="numeric">${pair ? t.after(last.iteration.number) : nameOf(last)}</th>`}
        ${changes && html`<th scope="col" class="numeric">${t.change}</th>`}
        ${drawn && html`<th scope="col">${t.drawn}</th>`}
        <th scope="col" class="numeric">${t.limits}</th><th scope="col" class="numeric">${t.class}</th>
      </tr></thead>
      <tbody>
        ${
          without.length === data.length
            ? fact(t.allFlank, () => absent(whyFigures))
            : flank.map((one) => row(one, whyFigures))
        }
        ${traces.map((one) => row(one, whyClass))}
        ${fact(t.coarsest, (one) => {
          const of = coarsest(one);
          if (of === undefined) return absent(whyClass);
          return of > 11 ? t.above11 : verbatim(fmt.value.count(of));
        })}
        ${fact(t.heights, (one) => heights(one, notes.mark))}
        ${fact(t.rms, ({ fit, iteration }) => withUnit(fit?.result.residuals.rms, iteration))}
        ${fact(t.regularized, ({ fit }) => chosen(fit))}
        ${fact(t.condition, ({ fit }) => condition(fit))}
      </tbody>
    </table>
    <div class="report-notes">
      <p>${notes.all().map(({ sign, text }) => html`<span key=${sign}><sup translate="no">${sign}</sup> ${text} </span>`)}</p>
      ${
        drawn &&
        html`<p>${h(StripLegend, {
          estimates: listed.flatMap(drawnOf),
          limited: listed.some((one) => one.limits && drawnOf(one).length > 0),
          named: data.map((one, i) => ({ ...ENDS[i], name: common.iteration(one.iteration.number) })),
        })}</p>`
      }
      <p>${without.length < data.length && html`${{ fits: t.ofFits, nodes: t.ofNodes, traces: t.ofTraces }[source]} `}${t.errors}${changes && html` ${t.changeAbout}`}
        ${decided && OUTCOMES.map((one) => html` <span key=${one} class="sign"><b aria-hidden="true">${VERDICTS[one].sign}</b> ${words[one]}</span>`)}${why && ` ${words.whyDoubtful(why)}`}</p>
    </div>
  </div>`;
}

/** Reasons, each with the letter by which cells refer to it. */
function notesOf() {
  /** @type {string[]} */
  const texts = [];
  const sign = (/** @type {number} */ i) => String.fromCharCode(97 + i);
  return {
    /** @param {string} text */
    mark: (text) => {
      if (!texts.includes(text)) texts.push(text);
      return html`<sup translate="no">${sign(texts.indexOf(text))}</sup>`;
    },
    all: () => texts.map((text, i) => ({ sign: sign(i), text })),
  };
}

/** The first and the last iteration, with colour and shape. @type {readonly Pick<import("../charts/strip.js").Drawn, "series" | "sign">[]} */
const ENDS = [
  { series: "blue", sign: "circle" },
  { series: "vermilion", sign: "diamond" },
];

/** @param {Row} row @returns {import("../charts/strip.js").Drawn[]} */
const drawnOf = ({ cells }) =>
  cells.some((cell) => cell?.error) ? cells.flatMap((cell, i) => (cell ? [{ ...ENDS[i], ...cell }] : [])) : [];

/** @param {string} text */
const verbatim = (text) => html`<span translate="no">${text}</span>`;

/** @param {Children} why */
const absent = (why) => html`<span class="quiet">${ABSENT}${why}</span>`;

/** @param {Cell | undefined} cell @param {Children} why */
function figure(cell, why) {
  if (!cell) return absent(why);
  return verbatim(cell.error ? fmt.value.withError(cell.value, cell.error) : fmt.value.um(cell.value));
}

const OUTCOMES = /** @type {const} */ (["conforms", "does_not_conform", "undecidable", "doubtful"]);

/** Limits, and the conformity of the last figure. @param {import("./figures.js").Limits} limits @param {readonly (Cell | undefined)[]} cells */
function limitsOf({ low, high }, cells) {
  return html`${verbatim(fmt.value.interval([low, high], 1))} ${h(Decided, { conformity: cells.at(-1)?.conformity })}`;
}

/** Reasons to doubt the last figures. @param {readonly Row[]} rows */
function reasonsOf(rows) {
  const found = rows.flatMap(({ cells }) => cells.at(-1)?.conformity?.reasons ?? []);
  return [...new Set(found)].map(words.because).join(", ");
}

/** The classes before and after. @param {readonly (Cell | undefined)[]} cells */
function classesOf(cells) {
  if (cells.every((cell) => cell?.class === undefined)) return null;
  return verbatim(cells.map((cell) => (cell?.class === undefined ? ABSENT : String(cell.class))).join(" → "));
}

/** @param {ReportData} data @param {(text: string) => Children} mark */
function heights(data, mark) {
  const ends = heightsOf(data);
  if (!ends) return absent(mark(t.whyHeights));
  const unit = heightUnit(data.iteration.axes);
  const write = unit === "µm" ? fmt.value.um : unit === "mm" ? fmt.value.mm : fmt.value.three;
  return verbatim(`${write(ends.low)} … ${write(ends.high)}${unit ? `\u202f${unit}` : ""}`);
}

/** @param {number | null | undefined} value @param {ReportData["iteration"]} iteration */
function withUnit(value, { axes }) {
  const unit = heightUnit(axes);
  return verbatim(value == null ? ABSENT : `${fmt.value.three(value)}${unit ? `\u202f${unit}` : ""}`);
}

/** λ* and its criterion. @param {ReportData["fit"]} fit */
function chosen(fit) {
  const { lambda_star: value, criterion } = fit?.result.regularization ?? {};
  if (value === undefined) return fit ? t.unregularized : ABSENT;
  return html`${verbatim(fmt.value.three(value))} <code translate="no">${criterion}</code>`;
}

/** @param {ReportData["fit"]} fit */
function condition(fit) {
  const { condition: before, regularized } = fit?.result.spectrum ?? {};
  const after = regularized?.condition;
  return verbatim(
    after == null ? fmt.value.condition(before) : `${fmt.value.condition(before)} → ${fmt.value.condition(after)}`,
  );
}
