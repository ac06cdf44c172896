// The traces of one kind as on a printed tester sheet: left flanks on the left, teeth side by side,
// one scale for all.

import { KChart, PIXEL } from "../charts/k_chart.js";
import { useWidth } from "../charts/chart.js";
import { t } from "../i18n/evaluation.js";
import { t as flankText } from "../i18n/flank.js";
import { fmt } from "../i18n/i18n.js";
import { dashOf } from "../lib/colour.js";
import { hangingBand, magnification, outsideBy, requiredBands, sheetOf } from "../lib/traces.js";
import { bandWords, symbolsOf } from "./evaluation_table.js";
import { useAsTable } from "./as_table.js";
import { useMedia } from "./media.js";
import { Within } from "./within.js";
import { GearSymbol } from "./symbol.js";
import { TraceTable } from "./trace_table.js";
import { h, html } from "../../vendor/ui.js";

/** @typedef {import("../lib/traces.js").GearTrace} GearTrace */
/** @typedef {import("../lib/traces.js").EvaluatedTrace} EvaluatedTrace */
/** @typedef {import("../api/client.js").Schema<"GearEvaluation">} GearEvaluation */
/** @typedef {import("../api/client.js").Schema<"Gear">} Gear */
/** @typedef {import("../api/client.js").Schema<"KBandFinding">} KBandFinding */

/**
 * @param {{ kind: "profile" | "helix", traces: readonly GearTrace[], evaluation: GearEvaluation, gear: Gear | undefined, band: number | undefined, required?: boolean, paper?: boolean }} props
 *   `band`: its width, µm; `required`: instead of it the bands that traces were held against, where they were;
 *   `traces`: as posted, in the order of the result; `paper`: upright whatever the screen, four side by side
 */
export function EvaluationSheet({ kind, traces, evaluation, gear, band, required = false, paper = false }) {
  const narrow = useNarrow();
  const flat = narrow && !paper;
  const [box, width] = useWidth();
  const settings = evaluation.evaluation;
  const drawn = traces
    .map((trace, i) => ({ trace, evaluated: evaluation.traces[i] }))
    .flatMap(({ trace, evaluated }) => {
      if (!evaluated || trace.kind !== kind) return [];
      const sheet = sheetOf(trace, evaluated, settings, gear);
      const requiredOnes = required && gear ? requiredBands(sheet, trace, evaluated, settings, gear) : [];
      const bands = requiredOnes.length > 0 || band === undefined ? requiredOnes : hangingBand(sheet, band);
      return [{ trace, evaluated, sheet, bands }];
    });
  const scale = scaleOf(drawn, flat ? Math.max(200, width - 80) : paper ? 340 : 420, flat ? 140 : paper ? 94 : 230);
  const { value } = fmt;
  return html`<div class="k-sheet" ref=${box}>
    ${["left", "right"].map((flank) => {
      const own = drawn.filter(({ trace }) => trace.flank === flank);
      if (own.length === 0) return null;
      const words = flank === "left" ? t.left : t.right;
      return html`<section key=${flank} class="k-flank">
        <h3>${words}</h3>
        <div class="k-teeth">
          ${own.map(({ trace, evaluated, sheet, bands }, i) => {
            const name = [t[kind], t.tooth(trace.tooth), words].join(", ");
            return h(Drawn, { key: i, trace, evaluated, sheet, bands, name, scale, flat, gear, paper });
          })}
        </div>
      </section>`;
    })}
    <p class="hint">${(paper ? t.magnificationOnPaper : t.magnification)(value.fixed(scale.magnified[0], 0), value.fixed(scale.magnified[1], 0))}</p>
  </div>`;
}

/**
 * A trace: its chart, or the same as a table, and its figures.
 * @param {{ trace: GearTrace, evaluated: EvaluatedTrace, sheet: import("../lib/traces.js").Sheet, bands: readonly import("../lib/traces.js").DrawnBand[],
 *   name: string, scale: import("../charts/k_chart.js").KScale, flat: boolean, gear: Gear | undefined, paper: boolean }} props
 */
function Drawn({ trace, evaluated, sheet, bands, name, scale, flat, gear, paper }) {
  const { kind } = trace;
  const { asTable, button } = useAsTable(name);
  const { value } = fmt;
  const outside = sheet.samples.filter((one, k) => bands.some(({ limits }) => outsideBy(one, limits[k]) !== 0));
  const profileEnds = gear?.internal ? [flankText.tip, flankText.root] : [flankText.root, flankText.tip];
  const faceEnds = flat ? [flankText.faceI, flankText.faceII] : [flankText.shortI, flankText.shortII];
  return html`<figure>
    ${
      asTable
        ? h(TraceTable, { trace, sheet, bands, rolled: gear !== undefined, name })
        : h(KChart, {
            sheet,
            scale,
            bands,
            flat,
            dash: dashOf(trace.flank),
            ends: /** @type {[string, string]} */ (kind === "profile" ? profileEnds : faceEnds),
            name,
            summary: t.chartSummary(
              value.um(evaluated.slope_um),
              value.um(evaluated.form_um),
              value.um(evaluated.total_um),
            ),
          })
    }
    <figcaption>
      <b>${t.tooth(trace.tooth)}</b>
      ${h(Values, { kind, evaluated })}
      ${bands.some((one) => one.required) && h(Bands, { found: evaluated.k_bands ?? [] })}
      ${outside.length > 0 && html`<span class="k-count">${t.outside(outside.length)}</span>`}
      ${!paper && html`<span>${button}</span>`}
    </figcaption>
  </figure>`;
}

/** The figures of a trace, as sheets print them below it. @param {{ kind: "profile" | "helix", evaluated: EvaluatedTrace }} props */
function Values({ kind, evaluated }) {
  const { slope, form, total, crowning } = symbolsOf(kind);
  const values = /** @type {const} */ ([
    [slope, evaluated.slope_um],
    [form, evaluated.form_um],
    [total, evaluated.total_um],
    [crowning, evaluated.crowning_um],
  ]);
  return html`<dl class="k-values" translate="no">
    ${values.map(([symbol, value]) => html`<div key=${symbol}><dt>${h(GearSymbol, { name: symbol })}</dt><dd>${fmt.value.um(value)}</dd></div>`)}
  </dl>`;
}

/** Returns true if a trace lies in its required bands. @param {{ found: readonly KBandFinding[] }} props */
function Bands({ found }) {
  return found.map(
    (one) => html`<span key=${one.band} class="k-found">${h(Within, { within: one.within })} ${bandWords(one)}</span>`,
  );
}

/**
 * Returns the scale of all charts of a sheet.
 * @param {readonly { sheet: import("../lib/traces.js").Sheet, bands: readonly import("../lib/traces.js").DrawnBand[] }[]} drawn @param {number} long pixels @param {number} wide pixels
 */
function scaleOf(drawn, long, wide) {
  const edges = drawn.flatMap(({ bands }) => bands.flatMap(({ upper, lower }) => [...upper, ...lower]));
  const places = drawn.flatMap(({ sheet }) => [...sheet.samples.map(({ at }) => at), ...(sheet.range ?? [])]);
  places.push(...edges.map(({ at }) => at));
  const heights = drawn.flatMap(({ sheet }) =>
    sheet.samples.flatMap(({ value, design }) => (value === null ? [] : [value, design])),
  );
  heights.push(...edges.map(({ value }) => value));
  const [low, high] = [Math.min(...places), Math.max(...places)];
  const [least, most] = [Math.floor(Math.min(0, ...heights) - 0.5), Math.ceil(Math.max(0, ...heights) + 0.5)];
  const forLength = magnification(high - low, long * PIXEL);
  const forDeviation = magnification((most - least) / 1000, wide * PIXEL);
  return {
    length: /** @type {const} */ ([low, high]),
    deviation: /** @type {const} */ ([least, most]),
    perLength: forLength / PIXEL,
    perDeviation: forDeviation / 1000 / PIXEL,
    magnified: /** @type {const} */ ([forDeviation, forLength]),
  };
}

/** Returns true if charts lie flat. */
const useNarrow = () => useMedia("(max-width: 799.98px)");
