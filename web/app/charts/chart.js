// A chart: a name, a summary sentence, SVG with axes, points that pointer and keyboard read out,
// and the same as a table.
//
//     h(Chart, { name, summary, x, y, probes, data, children: (plot) => h(Line, { plot, points }) })

import { table } from "../components/table.js";
import { t } from "../i18n/common.js";
import { fmt } from "../i18n/i18n.js";
import { h, html, useEffect, useId, useLayoutEffect, useRef, useState } from "../../vendor/ui.js";
import { scaleOf, ticksOf } from "./scale.js";

/** @typedef {import("../../vendor/ui.js").ComponentChildren} Children */
/** @typedef {import("./scale.js").AxisSpec} AxisSpec */
/** @typedef {{ x: import("./scale.js").Scale, y: import("./scale.js").Scale, width: number, height: number }} Plot */
/** @typedef {{ x: number, y: number, text: string }} Probe a point to be read out, and its words */
/**
 * The values of a chart as a table.
 * @template Row
 * @typedef {{ columns: readonly import("../components/table.js").Column<Row>[], rows: readonly Row[], rowKey: (row: Row) => string | number, csvName: string }} ChartData
 */

const MARGIN = { top: 12, right: 16, bottom: 44, left: 70 };
/** Width of a digit of a tick, and of the axis title next to it, pixels. */
const [DIGIT, TITLE] = [7, 34];

/**
 * @param {{
 *   name: string,
 *   summary: string,
 *   x: AxisSpec,
 *   y: AxisSpec,
 *   height?: number,
 *   children: (plot: Plot) => Children,
 *   probes?: readonly Probe[],
 *   onPick?: ((probe: Probe, index: number) => void) | undefined,
 *   data?: ChartData<any> | undefined,
 *   tools?: Children,
 *   level?: 2 | 3,
 * }} props `onPick`: a click or Enter on a point
 */
export function Chart({ name, summary, x, y, height = 320, children, probes = [], onPick, data, tools, level = 3 }) {
  const id = useId();
  const [asTable, setAsTable] = useState(false);
  const [at, setAt] = useState(/** @type {number | null} */ (null));
  const [box, width] = useWidth();
  const plot = plotOf(x, y, width, height);
  const left = width - MARGIN.right - plot.width;
  const probe = at === null ? undefined : probes[at];
  const heading = level === 2 ? html`<h2 id=${id}>${name}</h2>` : html`<h3 id=${id}>${name}</h3>`;

  const drawing = () => html`<svg class="chart" width=${width} height=${height} viewBox=${`0 0 ${width} ${height}`}
    role=${probes.length > 0 ? undefined : "img"} aria-hidden=${probes.length > 0 ? "true" : undefined}
    aria-labelledby=${probes.length > 0 ? undefined : id} aria-describedby=${probes.length > 0 ? undefined : `${id}-summary`}>
    <g transform=${`translate(${left} ${MARGIN.top})`}>
      ${h(Axes, { plot, x, y, left })}
      ${children(plot)}
      ${probe && h(Crosshair, { plot, probe })}
    </g>
  </svg>`;

  return html`<figure class="chart-figure" aria-labelledby=${id}>
    <figcaption>
      ${heading}
      <div class="actions">
        ${tools}
        ${
          data &&
          html`<button type="button" class="button small" aria-pressed=${asTable} onClick=${() => setAsTable(!asTable)}>
          ${asTable ? t.asChart : t.asTable}
        </button>`
        }
      </div>
    </figcaption>
    <div class="chart-said">
      <p class="quiet chart-summary" id=${`${id}-summary`}>${summary}</p>
      ${probes.length > 0 && !asTable && html`<p class="chart-readout" aria-hidden="true">${probe?.text}</p>`}
    </div>
    ${
      asTable && data
        ? table({ ...data, caption: name, hideCaption: true })
        : html`<div class="chart-box" ref=${box}>
            ${probes.length > 0 ? h(Reader, { id, name, probes, at, setAt, plot, left, onPick, children: drawing() }) : drawing()}
          </div>`
    }
  </figure>`;
}

/**
 * Reads points out, as a slider for screen readers.
 * @param {{ id: string, name: string, probes: readonly Probe[], at: number | null, setAt: (at: number | null) => void, plot: Plot, left: number,
 *   onPick: ((probe: Probe, index: number) => void) | undefined, children: Children }} props
 */
function Reader({ id, name, probes, at, setAt, plot, left, onPick, children }) {
  const last = probes.length - 1;
  const now = Math.min(at ?? 0, last);
  const pick = (/** @type {number} */ index) => {
    const probe = probes[index];
    if (probe) onPick?.(probe, index);
  };
  const press = (/** @type {KeyboardEvent} */ event) => {
    const step = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: 10, PageDown: -10 }[event.key];
    if (step !== undefined) setAt(at === null ? now : Math.min(last, Math.max(0, now + step)));
    else if (event.key === "Home") setAt(0);
    else if (event.key === "End") setAt(last);
    else if (event.key === "Escape") setAt(null);
    else if (event.key === "Enter" && onPick) pick(now);
    else return;
    event.preventDefault();
  };
  const point = (/** @type {PointerEvent & { currentTarget: Element }} */ event) => {
    const box = event.currentTarget.getBoundingClientRect();
    setAt(nearest(probes, plot, event.clientX - box.left - left, event.clientY - box.top - MARGIN.top));
  };
  return html`<div class="chart-reader" tabindex="0" role="slider" aria-label=${name} aria-describedby=${`${id}-summary`}
    aria-valuemin="1" aria-valuemax=${last + 1} aria-valuenow=${now + 1} aria-valuetext=${probes[now]?.text ?? ""}
    onKeyDown=${press} onPointerMove=${point} onPointerLeave=${() => setAt(null)} onFocus=${() => setAt(now)}
    onBlur=${() => setAt(null)} onClick=${() => at !== null && pick(at)}>${children}</div>`;
}

/** @param {readonly Probe[]} probes @param {Plot} plot @param {number} px @param {number} py */
function nearest(probes, plot, px, py) {
  let best = /** @type {number | null} */ (null);
  let least = Number.POSITIVE_INFINITY;
  for (const [i, { x, y }] of probes.entries()) {
    // along x first: a pointer that follows a line need not stay on it
    const distance = Math.abs(plot.x(x) - px) + 0.15 * Math.abs(plot.y(y) - py);
    if (distance < least) [best, least] = [i, distance];
  }
  return best;
}

/** A missing value: a place only. @param {{ plot: Plot, probe: Probe }} props */
function Crosshair({ plot, probe }) {
  const [x, y] = [plot.x(probe.x), plot.y(probe.y)];
  const across = Number.isFinite(y);
  return html`<g class="chart-crosshair">
    <path d=${`M${x} 0V${plot.height}${across ? `M0 ${y}H${plot.width}` : ""}`} />
    ${across && html`<circle cx=${x} cy=${y} r="5" />`}
  </g>`;
}

/** @param {{ plot: Plot, x: AxisSpec, y: AxisSpec, left: number }} props `left`: what is left of the axes, pixels */
function Axes({ plot, x, y, left }) {
  const across = ticksOf(plot.x, { ticks: plot.width < 420 ? 4 : 7, ...x }, fmt.value);
  const up = ticksUp(plot.y, y);
  const title = (/** @type {AxisSpec} */ { label, unit }) =>
    html`${label}${unit && html`<tspan translate="no">${` / ${unit}`}</tspan>`}`;
  return html`<g class="chart-axes">
    ${across.map(({ value, label }) => {
      const at = plot.x(value);
      return html`<g key=${`x${value}`}>
        <path class=${label === null ? "minor" : "grid"} d=${`M${at} ${label === null ? plot.height - 4 : 0}V${plot.height}`} />
        ${label !== null && html`<text x=${at} y=${plot.height + 16} text-anchor="middle" translate="no">${label}</text>`}
      </g>`;
    })}
    ${up.map(({ value, label }) => {
      const at = plot.y(value);
      return html`<g key=${`y${value}`}>
        <path class=${label === null ? "minor" : "grid"} d=${`M0 ${at}H${label === null ? 4 : plot.width}`} />
        ${label !== null && html`<text x="-8" y=${at} dy="0.35em" text-anchor="end" translate="no">${label}</text>`}
      </g>`;
    })}
    <path class="frame" d=${`M0 0V${plot.height}H${plot.width}`} />
    <text class="axis-title" x=${plot.width / 2} y=${plot.height + 36} text-anchor="middle">${title(x)}</text>
    <text class="axis-title" transform=${`translate(${14 - left} ${plot.height / 2}) rotate(-90)`} text-anchor="middle">${title(y)}</text>
  </g>`;
}

/** @param {import("./scale.js").Scale} scale @param {AxisSpec} y */
const ticksUp = (scale, y) => ticksOf(scale, { ticks: 6, ...y }, fmt.value);

/** @param {AxisSpec} x @param {AxisSpec} y @param {number} width @param {number} height @returns {Plot} */
function plotOf(x, y, width, height) {
  const tall = height - MARGIN.top - MARGIN.bottom;
  const up = scaleOf(y, [tall, 0]);
  // long ticks push the axis to the right
  const longest = Math.max(0, ...ticksUp(up, y).map(({ label }) => label?.length ?? 0));
  const inner = Math.max(40, width - Math.max(MARGIN.left, TITLE + DIGIT * longest) - MARGIN.right);
  return { x: scaleOf(x, [0, inner]), y: up, width: inner, height: tall };
}

/** Returns the width of an element, as it changes. @returns {[import("../../vendor/ui.js").RefObject<HTMLDivElement | null>, number]} */
export function useWidth() {
  const box = useRef(/** @type {HTMLDivElement | null} */ (null));
  const [width, setWidth] = useState(640);
  useLayoutEffect(() => {
    if (box.current) setWidth(Math.max(160, Math.floor(box.current.clientWidth)));
  });
  useEffect(() => {
    const element = box.current;
    if (!element) return undefined;
    const observer = new ResizeObserver(() => setWidth(Math.max(160, Math.floor(element.clientWidth))));
    observer.observe(element);
    return () => observer.disconnect();
  });
  return [box, width];
}
