// The effect of λ*: predicted error, condition, RMS, GCV and bias along it.

import { Chart } from "../charts/chart.js";
import { rowsOfLabels } from "../charts/labels.js";
import { Dots, Line, Span } from "../charts/marks.js";
import de from "../i18n/de/lambda.js";
import en from "../i18n/en/lambda.js";
import { fmt, texts } from "../i18n/i18n.js";
import { h, html } from "../../vendor/ui.js";

/** @typedef {import("../api/client.js").Schema<"FitResult">} FitResult */
/** @typedef {import("../api/client.js").Schema<"LambdaCurvePoint">} Point */
/** @typedef {"predicted_mse" | "condition" | "rms" | "gcv" | "bias_norm"} Quantity */

const t = texts({ en, de });

/**
 * @param {{
 *   curve: readonly Point[], result: FitResult, chosenLambda: number | undefined, shown: number | undefined,
 *   symbol: string, unit: string | undefined, onPick: (value: number) => void,
 * }} props `chosenLambda`, `shown`: values of λ* that are marked
 */
export function Curves({ curve, result, chosenLambda, shown, symbol, unit, onPick }) {
  /** @type {readonly { of: Quantity, name: string, unit?: string | undefined }[]} */
  const quantities = [
    { of: "predicted_mse", name: t.predictedMse },
    { of: "condition", name: t.condition },
    { of: "rms", name: t.rms, unit },
    { of: "gcv", name: t.gcv },
    { of: "bias_norm", name: t.biasNorm },
  ];
  const there = quantities.filter(({ of }) => curve.some((point) => typeof point[of] === "number"));
  const common = { curve, result, chosenLambda, shown, symbol, onPick };
  const [first, ...rest] = there;
  if (!first) return null;
  return html`<section class="panel lambda-curves" aria-labelledby="lambda-curves">
    <h2 id="lambda-curves">${t.curves(symbol)}</h2>
    ${h(OneCurve, { ...common, ...first, labelled: true })}
    ${h(Legend, { shown: shown !== undefined, plateau: result.regularization.lambda_star_interval !== undefined, symbol })}
    <div class="lambda-small">${rest.map((one) => h(OneCurve, { key: one.of, ...common, ...one, labelled: false }))}</div>
  </section>`;
}

/**
 * @param {{
 *   of: Quantity, name: string, unit?: string | undefined, labelled: boolean, curve: readonly Point[], result: FitResult,
 *   chosenLambda: number | undefined, shown: number | undefined, symbol: string, onPick: (value: number) => void,
 * }} props
 */
function OneCurve({ of, name, unit, labelled, curve, result, chosenLambda, shown, symbol, onPick }) {
  const points = curve.flatMap((point) => {
    const y = point[of];
    return typeof y === "number" ? [{ x: point.lambda_star, y }] : [];
  });
  const positive = points.filter(({ y }) => y > 0).map(({ y }) => y);
  const [low, high] = [Math.min(...positive), Math.max(...positive)];
  const log = positive.length > 0 && high > 8 * low;
  const from = log ? Math.max(low, high / 1e9) : Math.min(...points.map(({ y }) => y));
  // space above the line for the labels
  const room = labelled ? 0.4 : 0.06;
  const top = log ? high * (high / from) ** room : high + room * (high - from);
  const [start, end] = [curve[0]?.lambda_star ?? 1, curve.at(-1)?.lambda_star ?? 10];
  const least = points.reduce((a, b) => (b.y < a.y ? b : a), points[0] ?? { x: start, y: 0 });
  const number = of === "condition" ? fmt.value.condition : fmt.value.three;
  const span = result.regularization.lambda_star_interval;
  return h(Chart, {
    name,
    summary: t.curveSummary(number(least.y), symbol, fmt.value.three(least.x)),
    x: { label: t.symbol(symbol), scale: "log", domain: [start, end] },
    y: { label: name, unit, scale: log ? "log" : "linear", domain: [from, top] },
    height: labelled ? 380 : 230,
    probes: points.map(({ x, y }) => ({ x, y, text: `${symbol} ${fmt.value.three(x)}: ${number(y)}` })),
    onPick: ({ x }) => onPick(x),
    data: {
      columns: [
        {
          key: "x",
          header: t.symbol(symbol),
          numeric: true,
          rowHeader: true,
          cell: ({ x }) => fmt.value.three(x),
          csv: ({ x }) => x,
        },
        { key: "y", header: name, unit, numeric: true, cell: ({ y }) => number(y), csv: ({ y }) => y },
      ],
      rows: points,
      rowKey: ({ x }) => x,
      csvName: `lambda-${of}`,
    },
    children: (plot) => html`
      ${span && h(Span, { plot, from: span[0] ?? 0, to: span[1] ?? 0 })}
      ${h(ChoiceMarks, { plot, choices: result.regularization.choices, labelled })}
      ${h(Line, { plot, points: log ? points.map(({ x, y }) => ({ x, y: y > 0 ? Math.max(y, from) : null })) : points })}
      ${chosenLambda !== undefined && h(Mark, { plot, points, at: chosenLambda, sign: "square", series: "vermilion" })}
      ${shown !== undefined && h(Mark, { plot, points, at: shown, sign: "circle", series: "green" })}`,
  });
}

/** The choices of the criteria, in rows to avoid overlaps. @param {{ plot: import("../charts/chart.js").Plot, choices: FitResult["regularization"]["choices"], labelled: boolean }} props */
function ChoiceMarks({ plot, choices, labelled }) {
  const marks = choices.flatMap(({ criterion, lambda_star: value }) =>
    value === undefined ? [] : [{ x: Math.min(plot.width, Math.max(0, plot.x(value))), label: criterion }],
  );
  return html`<g class="mark-rule choice" translate="no">
    ${rowsOfLabels(marks, plot.width).map(({ x, label, row, end }) => {
      const y = 12 + 16 * row;
      return html`<g key=${label}>
        <path d=${`M${x} ${labelled ? y - 10 : 0}V${plot.height}`} />
        ${labelled && html`<text class="choice-label" x=${x + (end ? -4 : 4)} y=${y} text-anchor=${end ? "end" : "start"}>${t.symbol(label)}</text>`}
      </g>`;
    })}
  </g>`;
}

/** Returns a place on a line, interpolated between its points on log axes. @param {{ plot: import("../charts/chart.js").Plot, points: readonly { x: number, y: number }[], at: number, sign: "square" | "circle", series: "vermilion" | "green" }} props */
function Mark({ plot, points, at, sign, series }) {
  const next = points.findIndex(({ x }) => x >= at);
  const [a, b] = [points[Math.max(0, next - 1)], points[next < 0 ? points.length - 1 : next]];
  if (!a || !b) return null;
  const part = a.x === b.x ? 0 : Math.log(at / a.x) / Math.log(b.x / a.x);
  const y = a.y > 0 && b.y > 0 ? a.y * (b.y / a.y) ** Math.min(1, Math.max(0, part)) : b.y;
  return h(Dots, { plot, points: [{ x: at, y }], sign, series });
}

/** @param {{ shown: boolean, plateau: boolean, symbol: string }} props */
function Legend({ shown, plateau, symbol }) {
  return html`<ul class="lambda-legend quiet">
    <li><svg width="28" height="12" aria-hidden="true" class="chart"><path class="mark-rule-sample" d="M14 0V12" /></svg>${t.choiceOf}</li>
    <li><svg width="14" height="12" aria-hidden="true" class="chart mark-dots series-vermilion"><path d="M3.5 2.5h7v7h-7z" /></svg>${t.chosenMark}</li>
    ${shown && html`<li><svg width="14" height="12" aria-hidden="true" class="chart mark-dots series-green"><path d="M3 6a4 4 0 1 0 8 0a4 4 0 1 0 -8 0" /></svg>${t.shownMark}</li>`}
    ${plateau && html`<li><svg width="18" height="12" aria-hidden="true" class="chart mark-span"><rect width="18" height="12" /></svg>${t.plateau(symbol)}</li>`}
  </ul>`;
}
