// Marks of charts. Each takes the chart's frame, and values in the units of its axes.

import { area, curveStepAfter, line } from "../../vendor/d3.js";
import { html, useId } from "../../vendor/ui.js";

/** @typedef {import("./chart.js").Plot} Plot */
/** @typedef {(typeof import("../lib/colour.js").SERIES)[number]} Series */
/** @typedef {{ x: number, y: number | null | undefined }} Point without y: a gap */

/** @param {number | null | undefined} value @returns {value is number} */
const finite = (value) => typeof value === "number" && Number.isFinite(value);

/**
 * A line through points in their order; left flanks solid, right ones dashed.
 * @param {{ plot: Plot, points: readonly Point[], series?: Series, dash?: string | undefined, thin?: boolean, steps?: boolean }} props
 */
export function Line({ plot, points, series = "blue", dash, thin = false, steps = false }) {
  const path = line(
    (/** @type {Point} */ { x }) => plot.x(x),
    ({ y }) => plot.y(/** @type {number} */ (y)),
  ).defined(({ x, y }) => finite(plot.x(x)) && finite(y) && finite(plot.y(y)));
  if (steps) path.curve(curveStepAfter);
  return html`<path class=${`mark-line series-${series}${thin ? " thin" : ""}`} d=${path([...points])} stroke-dasharray=${dash} />`;
}

/**
 * An area between two values: an interval, a range, a tolerance.
 * @param {{ plot: Plot, points: readonly { x: number, low: number | null | undefined, high: number | null | undefined }[], series?: Series, hatched?: boolean }} props
 */
export function Band({ plot, points, series = "blue", hatched = false }) {
  const id = useId();
  const path = area(
    (/** @type {(typeof points)[number]} */ { x }) => plot.x(x),
    ({ low }) => plot.y(/** @type {number} */ (low)),
    ({ high }) => plot.y(/** @type {number} */ (high)),
  ).defined(({ low, high }) => finite(low) && finite(high));
  if (!hatched) return html`<path class=${`mark-band series-${series}`} d=${path([...points])} />`;
  return html`<g class=${`series-${series}`}>
    <pattern id=${id} width="6" height="6" patternUnits="userSpaceOnUse" patternTransform="rotate(45)">
      <path class="mark-hatch" d="M0 0v6" />
    </pattern>
    <path class="mark-hatched" d=${path([...points])} fill=${`url(#${id})`} />
  </g>`;
}

/** A part of the x axis, over the full height. @param {{ plot: Plot, from: number, to: number, label?: string }} props */
export function Span({ plot, from, to, label }) {
  const [left, right] = [plot.x(from), plot.x(to)].sort((a, b) => a - b);
  if (!finite(left) || !finite(right)) return null;
  return html`<g class="mark-span">
    <rect x=${left} y="0" width=${right - left} height=${plot.height} />
    ${label && html`<text x=${(left + right) / 2} y=${plot.height - 8} text-anchor="middle">${label}</text>`}
  </g>`;
}

const SIGNS = /** @type {const} */ ({
  circle: "M-4 0a4 4 0 1 0 8 0a4 4 0 1 0 -8 0",
  square: "M-3.5 -3.5h7v7h-7z",
  diamond: "M0 -5L5 0L0 5L-5 0z",
  cross: "M-4 -4L4 4M4 -4L-4 4",
});

/** @param {{ plot: Plot, points: readonly Point[], series?: Series, sign?: keyof typeof SIGNS, small?: boolean }} props */
export function Dots({ plot, points, series = "blue", sign = "circle", small = false }) {
  const there = points.filter(({ y }) => finite(y));
  return html`<g class=${`mark-dots series-${series} ${sign}`}>
    ${there.map(({ x, y }, i) => {
      const place = `translate(${plot.x(x)} ${plot.y(/** @type {number} */ (y))})${small ? " scale(0.5)" : ""}`;
      return html`<path key=${i} d=${SIGNS[sign]} transform=${place} />`;
    })}
  </g>`;
}

/** Intervals as lines with ends, along x. @param {{ plot: Plot, points: readonly { y: number, low: number, high: number }[], series?: Series }} props */
export function Whiskers({ plot, points, series = "blue" }) {
  const paths = points.map(({ y, low, high }) => {
    const [at, from, to] = [plot.y(y), plot.x(low), plot.x(high)];
    return `M${from} ${at - 4}v8M${from} ${at}H${to}M${to} ${at - 4}v8`;
  });
  return html`<path class=${`mark-whiskers series-${series}`} d=${paths.join("")} />`;
}

/**
 * A labelled value of one axis: a limit, a choice.
 * @param {{ plot: Plot, x?: number, y?: number, label?: string, kind?: "limit" | "choice" | "zero", row?: number }} props
 *   `row`: of the label, so that labels do not overlap
 */
export function Rule({ plot, x, y, label, kind = "choice", row = 0 }) {
  if (y !== undefined) {
    const at = plot.y(y);
    return html`<g class=${`mark-rule ${kind}`}>
      <path d=${`M0 ${at}H${plot.width}`} />
      ${label && html`<text x=${plot.width - 4} y=${at - 4} text-anchor="end">${label}</text>`}
    </g>`;
  }
  const at = plot.x(x ?? 0);
  const end = at > plot.width * 0.75;
  return html`<g class=${`mark-rule ${kind}`}>
    <path d=${`M${at} 0V${plot.height}`} />
    ${label && html`<text x=${at + (end ? -4 : 4)} y=${12 + 14 * row} text-anchor=${end ? "end" : "start"}>${label}</text>`}
  </g>`;
}

/** Bars from 0, one for each bin; below it where they are negative. @param {{ plot: Plot, bins: readonly { from: number, to: number, count: number }[], series?: Series }} props */
export function Bars({ plot, bins, series = "blue" }) {
  return html`<g class=${`mark-bars series-${series}`}>
    ${bins.map(({ from, to, count }) => {
      const [left, right] = [plot.x(from), plot.x(to)];
      const [end, zero] = [plot.y(count), plot.y(0)];
      return html`<rect key=${from} x=${left + 0.5} y=${Math.min(end, zero)} width=${Math.max(1, right - left - 1)} height=${Math.abs(zero - end)} />`;
    })}
  </g>`;
}
