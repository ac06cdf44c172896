// A K-chart, as testers print it: the length upright (or flat on narrow screens), the deviation across.

import { fmt } from "../i18n/i18n.js";
import { outsideBy } from "../lib/traces.js";
import { html, useId } from "../../vendor/ui.js";

/** @typedef {import("../lib/traces.js").Sheet} Sheet */
/** @typedef {import("../lib/traces.js").Sample} Sample */
/** @typedef {import("../lib/traces.js").DrawnBand} DrawnBand */
/**
 * The scale that all charts of a sheet share.
 * @typedef {object} KScale
 * @property {readonly [number, number]} length mm
 * @property {readonly [number, number]} deviation µm
 * @property {number} perLength pixels for a mm
 * @property {number} perDeviation pixels for a µm
 */

/** Millimetres of a pixel, as CSS has them. */
export const PIXEL = 25.4 / 96;
const EDGE = { long: 18, across: 34, end: 34 };
/** Height of the ticks and the scale bar below the frame, pixels. */
const BELOW = 36;
/** The width of the unit at the end of an axis, pixels. */
const UNIT = 26;
/** The minimum distance of labels below each other, pixels. */
const LINE = 11;
/** The limits of the length of a scale bar, pixels: 3 … 20 mm. */
const [SHORTEST_BAR, LONGEST_BAR] = [3 / PIXEL, 20 / PIXEL];

/**
 * @param {{ sheet: Sheet, scale: KScale, bands?: readonly DrawnBand[], flat?: boolean, dash?: string | undefined, name: string, summary: string,
 *   ends: readonly [string, string] }} props `dash`: of right flanks; `ends`: what lies at the ends of the
 *   length axis
 */
export function KChart({ sheet, scale, bands = [], flat = false, dash, name, summary, ends }) {
  const id = useId();
  const long = (scale.length[1] - scale.length[0]) * scale.perLength;
  const wide = (scale.deviation[1] - scale.deviation[0]) * scale.perDeviation;
  const along = (/** @type {number} */ at) => (at - scale.length[0]) * scale.perLength;
  const across = (/** @type {number} */ value) => (value - scale.deviation[0]) * scale.perDeviation;
  /** @param {number} at @param {number} value */
  const point = (at, value) =>
    flat
      ? `${(EDGE.across + along(at)).toFixed(1)} ${(EDGE.long / 2 + wide - across(value)).toFixed(1)}`
      : `${(EDGE.across + across(value)).toFixed(1)} ${(EDGE.long / 2 + long - along(at)).toFixed(1)}`;
  const [width, height] = flat ? [long, wide] : [wide, long];
  const line = (/** @type {readonly { at: number, value: number }[]} */ points) =>
    points.length > 1 ? `M${points.map(({ at, value }) => point(at, value)).join("L")}` : "";
  const { samples } = sheet;
  const [a, b] = scale.deviation;
  const ticks = ticksOf(a, b, wide);
  const lengths = lengthLabels(scale.length, sheet.range, scale.perLength, flat);
  const side = flat ? [] : lengths.map(({ at }) => EDGE.long / 2 + long - along(at));
  const [whole, tall] = [width + EDGE.across + EDGE.end, height + EDGE.long + BELOW];
  return html`<svg class="k-chart chart" width=${`${(whole * PIXEL).toFixed(3)}mm`} height=${`${(tall * PIXEL).toFixed(3)}mm`}
    viewBox=${`0 0 ${whole} ${tall}`} role="img" aria-label=${`${name}. ${summary}`}>
    <pattern id=${id} width="5" height="5" patternUnits="userSpaceOnUse" patternTransform="rotate(45)"><path class="k-hatch" d="M0 0v5" /></pattern>
    ${ticks.map((value) => html`<path key=${value} class=${value === 0 ? "k-zero" : "k-grid"} d=${line(scale.length.map((at) => ({ at, value })))} />`)}
    ${ticks.map((value) => {
      const [x = 0, y = 0] = point(scale.length[0], value).split(" ").map(Number);
      return flat
        ? html`<text key=${`t${value}`} x=${EDGE.across - 5} y=${y} dy="0.35em" text-anchor="end" translate="no">${fmt.value.fixed(value, 0)}</text>`
        : html`<text key=${`t${value}`} x=${x} y=${y + 16} text-anchor="middle" translate="no">${fmt.value.fixed(value, 0)}</text>`;
    })}
    ${lengths.map(({ at, text, end }) => {
      const [x = 0, y = 0] = point(at, scale.deviation[0]).split(" ").map(Number);
      const kind = end ? "k-range-end" : undefined;
      return flat
        ? html`<text key=${`l${at}`} class=${kind} x=${Math.min(x, EDGE.across + width + EDGE.end - UNIT - labelWidth(text) / 2)} y=${y + 16} text-anchor="middle" translate="no">${text}</text>`
        : html`<text key=${`l${at}`} class=${kind} x=${EDGE.across - 5} y=${y} dy="0.35em" text-anchor="end" translate="no">${text}</text>`;
    })}
    ${units(flat, width, height, side)}
    ${scaleBars(scale, flat, width, height)}
    ${bands.map(
      ({ upper, lower, required }, i) =>
        html`<path key=${`band${i}`} class=${required ? "k-band required" : "k-band"} d=${`${line([...upper, ...[...lower].reverse()])}z`} />`,
    )}
    ${sheet.range?.map((at) => html`<path key=${at} class="k-range" d=${line(scale.deviation.map((value) => ({ at, value })))} />`)}
    ${samples.some(({ design }) => design !== 0) && html`<path class="k-design" d=${line(samples.map(({ at, design }) => ({ at, value: design })))} />`}
    ${runs(samples, () => true).map((run, i) => html`<path key=${`thin${i}`} class="k-trace thin" d=${line(run)} />`)}
    ${runs(samples, ({ inside }) => inside).map((run, i) => html`<path key=${`run${i}`} class="k-trace" d=${line(run)} stroke-dasharray=${dash} />`)}
    ${bands.flatMap(({ limits }, k) =>
      runs(samples, (sample, i) => outsideBy(sample, limits[i]) !== 0).map((run, i) => {
        const limit = run.map(({ at, value, index }) => ({
          at,
          value: value - outsideBy(/** @type {Sample} */ (samples[index]), limits[index]),
        }));
        const first = run[0];
        return html`<g key=${`out${k} ${i}`} class="k-outside">
          ${run.length > 1 && html`<path class="k-outside-area" d=${`${line([...run, ...limit.reverse()])}z`} fill=${`url(#${id})`} />`}
          ${
            run.length > 1
              ? html`<path class="k-outside-line" d=${line(run)} />`
              : first &&
                html`<path class="k-outside-line" d=${`M${point(first.at, first.value)}L${point(first.at, limit[0]?.value ?? first.value)}`} />`
          }
        </g>`;
      }),
    )}
    ${sheet.mean.length > 1 && html`<path class="k-mean" d=${line(sheet.mean)} />`}
    ${sheet.parabola.length > 1 && html`<path class="k-parabola" d=${line(sheet.parabola)} />`}
    ${ends.map((text, i) => endMark(text, i === 1, flat, width, height))}
  </svg>`;
}

/**
 * Units of the axes, as on printed sheets; the one left of the frame avoids the labels of lengths.
 * @param {boolean} flat @param {number} width @param {number} height @param {readonly number[]} taken places of length labels
 */
function units(flat, width, height, taken) {
  const top = EDGE.long / 2;
  const free = [top, top + 13, top + 26, top + 39].find((y) => taken.every((one) => Math.abs(one - y) >= LINE));
  const [below, side] = flat ? ["mm", "µm"] : ["µm", "mm"];
  return html`<g class="k-unit" translate="no">
    <text x=${EDGE.across + width + EDGE.end} y=${EDGE.long / 2 + height + 16} text-anchor="end">${below}</text>
    <text x="0" y=${(free ?? top) + 4}>${side}</text>
  </g>`;
}

/**
 * Returns the length of a scale bar that can be measured with a ruler: the usual one (10 µm or 1
 * mm) or, if it does not fit, the next of 1, 2, 5.
 * @param {number} usual @param {number} pixels for one unit @param {number} space pixels
 */
export function barLength(usual, pixels, space) {
  const longest = Math.min(LONGEST_BAR, space);
  const fits = (/** @type {number} */ one) => one * pixels >= SHORTEST_BAR && one * pixels <= longest;
  const steps = [-4, -3, -2, -1, 0, 1, 2, 3].flatMap((power) => [1, 2, 5].map((one) => Number(`${one}e${power}`)));
  return fits(usual) ? usual : (steps.findLast(fits) ?? usual);
}

/**
 * Scale bars for both directions, labelled with their lengths.
 * @param {KScale} scale @param {boolean} flat @param {number} width @param {number} height
 */
function scaleBars({ perLength, perDeviation }, flat, width, height) {
  const [below, side] = flat
    ? [barLength(1, perLength, width), barLength(10, perDeviation, height)]
    : [barLength(10, perDeviation, width), barLength(1, perLength, height)];
  const [long, up] = flat ? [below * perLength, side * perDeviation] : [below * perDeviation, side * perLength];
  const [belowUnit, sideUnit] = flat ? ["mm", "µm"] : ["µm", "mm"];
  const [x, y] = [EDGE.across, EDGE.long / 2 + height + 29];
  const [right, middle] = [EDGE.across + width + 7, EDGE.long / 2 + height / 2];
  return html`<g class="k-scale" translate="no">
    <path d=${`M${x} ${y}h${long}`} /><path d=${`M${x} ${y - 3}v6M${x + long} ${y - 3}v6`} />
    <text x=${x + long + 5} y=${y} dy="0.35em">${`${fmt.value.input(below)} ${belowUnit}`}</text>
    <path d=${`M${right} ${middle - up / 2}v${up}`} /><path d=${`M${right - 3} ${middle - up / 2}h6M${right - 3} ${middle + up / 2}h6`} />
    <text transform=${`translate(${right + 9} ${middle}) rotate(-90)`} dy="0.35em" text-anchor="middle">${`${fmt.value.input(side)} ${sideUnit}`}</text>
  </g>`;
}

/** Root or tip, face I or II: at the end of the axis, outside the frame. @param {string} text @param {boolean} last @param {boolean} flat @param {number} width @param {number} height */
function endMark(text, last, flat, width, height) {
  const right = EDGE.across + width;
  const [x, y, anchor] = flat
    ? [last ? right - 6 : EDGE.across + 6, EDGE.long / 2 + 13, last ? "end" : "start"]
    : [right + 5, last ? EDGE.long / 2 + 9 : EDGE.long / 2 + height, "start"];
  return html`<text key=${`end${last}`} class="k-end" x=${x} y=${y} text-anchor=${anchor}>${text}</text>`;
}

/** Returns stretches of existing samples that meet a condition. @param {readonly Sample[]} samples @param {(sample: Sample, index: number) => boolean} holds */
function runs(samples, holds) {
  /** @type {{ at: number, value: number, index: number }[][]} */
  const found = [];
  let open = false;
  for (const [index, sample] of samples.entries()) {
    if (sample.value === null || !holds(sample, index)) {
      open = false;
      continue;
    }
    const kept = { at: sample.at, value: sample.value, index };
    if (open) found.at(-1)?.push(kept);
    else found.push([kept]);
    open = true;
  }
  return found;
}

/** Returns ticks at whole µm, spaced by at least the width of their labels. @param {number} low @param {number} high @param {number} wide */
function ticksOf(low, high, wide) {
  const spacing = Math.max(-low, high) < 10 ? 20 : 30;
  const step = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000].find((one) => (one * wide) / (high - low) >= spacing) ?? 1000;
  const first = Math.ceil(low / step - 1e-9);
  return Array.from({ length: Math.floor(high / step + 1e-9) - first + 1 }, (_, i) => (first + i) * step);
}

/** Estimates the width of a label, pixels. @param {string} text */
const labelWidth = (text) => 6.5 * text.length;

/**
 * Returns the labels of the length axis: the ends of the evaluation range, and ticks that do not
 * overlap them.
 * @param {readonly [number, number]} length @param {readonly [number, number] | undefined} range @param {number} perLength pixels for a mm @param {boolean} flat
 * @returns {{ at: number, text: string, end: boolean }[]}
 */
function lengthLabels(length, range, perLength, flat) {
  const separate = (/** @type {{ at: number, text: string }} */ a, /** @type {{ at: number, text: string }} */ b) =>
    Math.abs(a.at - b.at) * perLength >= (flat ? (labelWidth(a.text) + labelWidth(b.text)) / 2 + 8 : LINE);
  const ends = (range ?? []).map((at) => {
    const whole = Math.abs(at * 10 - Math.round(at * 10)) < 0.05 || Math.abs(at) >= 100;
    return { at, text: fmt.value.fixed(at, whole ? 1 : 2), end: true };
  });
  const [first, last] = ends;
  const drawn = first && last && !separate(first, last) ? [first] : ends;
  const ticks = lengthTicks(length).map((at) => ({ at, text: fmt.value.fixed(at, 1), end: false }));
  return [...drawn, ...ticks.filter((tick) => drawn.every((end) => separate(tick, end)))];
}

/** @param {readonly [number, number]} length */
function lengthTicks([low, high]) {
  const step = [0.5, 1, 2, 5, 10, 20, 50, 100].find((one) => (high - low) / one <= 6) ?? 200;
  const first = Math.ceil(low / step - 1e-9);
  return Array.from({ length: Math.floor(high / step + 1e-9) - first + 1 }, (_, i) => (first + i) * step);
}
