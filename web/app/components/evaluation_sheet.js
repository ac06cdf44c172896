// The traces of one kind as on a printed tester sheet: left flanks on the left, teeth side by side, one scale for all.

import { KChart, PIXEL } from "../charts/k_chart.js";
import { useWidth } from "../charts/chart.js";
import { t } from "../i18n/evaluation.js";
import { t as flankText } from "../i18n/flank.js";
import { fmt } from "../i18n/i18n.js";
import { dashOf } from "../lib/colour.js";
import { highest, isOutside, magnification, sheetOf } from "../lib/traces.js";
import { symbolsOf } from "./evaluation_table.js";
import { GearSymbol } from "./symbol.js";
import { h, html, useEffect, useState } from "../../vendor/ui.js";

/** @typedef {import("../lib/traces.js").GearTrace} GearTrace */
/** @typedef {import("../lib/traces.js").EvaluatedTrace} EvaluatedTrace */
/** @typedef {import("../api/client.js").Schema<"GearEvaluation">} GearEvaluation */
/** @typedef {import("../api/client.js").Schema<"Gear">} Gear */

/**
 * @param {{ kind: "profile" | "helix", traces: readonly GearTrace[], evaluation: GearEvaluation, gear: Gear | undefined, band: number | undefined, paper?: boolean }} props
 *   `traces`: as posted, in the order of the answer; `paper`: upright whatever the screen, four beside each other
 */
export function EvaluationSheet({ kind, traces, evaluation, gear, band, paper = false }) {
  const narrow = useNarrow();
  const flat = narrow && !paper;
  const [box, width] = useWidth();
  const drawn = traces
    .map((trace, i) => ({ trace, evaluated: evaluation.traces[i] }))
    .flatMap(({ trace, evaluated }) =>
      evaluated && trace.kind === kind
        ? [{ trace, evaluated, sheet: sheetOf(trace, evaluated, evaluation.evaluation, gear) }]
        : [],
    );
  const scale = scaleOf(
    drawn.map(({ sheet }) => sheet),
    band,
    flat ? Math.max(200, width - 80) : paper ? 340 : 420,
    flat ? 140 : paper ? 94 : 230,
  );
  const { value } = fmt;
  return html`<div class="k-sheet" ref=${box}>
    ${["left", "right"].map((flank) => {
      const own = drawn.filter(({ trace }) => trace.flank === flank);
      if (own.length === 0) return null;
      const words = flank === "left" ? t.left : t.right;
      return html`<section key=${flank} class="k-flank">
        <h3>${words}</h3>
        <div class="k-teeth">
          ${own.map(({ trace, evaluated, sheet }, i) => {
            const top = highest(sheet) ?? 0;
            const outside = band === undefined ? 0 : sheet.samples.filter((one) => isOutside(one, top, band)).length;
            return html`<figure key=${i}>
              ${h(KChart, {
                sheet,
                scale,
                band,
                flat,
                dash: dashOf(trace.flank),
                ends:
                  kind === "profile"
                    ? gear?.internal
                      ? [flankText.tip, flankText.root]
                      : [flankText.root, flankText.tip]
                    : [flankText.shortI, flankText.shortII],
                name: [t[kind], t.tooth(trace.tooth), words].join(", "),
                summary: t.chartSummary(
                  value.um(evaluated.slope_um),
                  value.um(evaluated.form_um),
                  value.um(evaluated.total_um),
                ),
              })}
              <figcaption>
                <b>${t.tooth(trace.tooth)}</b>
                ${h(Values, { kind, evaluated })}
                ${outside > 0 && html`<span class="k-count">${t.outside(outside)}</span>`}
              </figcaption>
            </figure>`;
          })}
        </div>
      </section>`;
    })}
    <p class="hint">${t.magnification(value.fixed(scale.magnified[0], 0), value.fixed(scale.magnified[1], 0))}</p>
  </div>`;
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

/**
 * One scale for all charts of a sheet.
 * @param {readonly import("../lib/traces.js").Sheet[]} sheets @param {number | undefined} band @param {number} long pixels @param {number} wide pixels
 */
function scaleOf(sheets, band, long, wide) {
  const places = sheets.flatMap(({ samples, range }) => [...samples.map(({ at }) => at), ...(range ?? [])]);
  const heights = sheets.flatMap((sheet) => {
    const top = highest(sheet);
    return [
      ...sheet.samples.flatMap(({ value, design }) => (value === null ? [] : [value, design])),
      ...(band !== undefined && top !== undefined ? [top, top - band] : []),
    ];
  });
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

/** Whether charts lie flat. */
function useNarrow() {
  const [narrow, setNarrow] = useState(() => matchMedia("(max-width: 799.98px)").matches);
  useEffect(() => {
    const media = matchMedia("(max-width: 799.98px)");
    const follow = () => setNarrow(media.matches);
    media.addEventListener("change", follow);
    return () => media.removeEventListener("change", follow);
  }, []);
  return narrow;
}
