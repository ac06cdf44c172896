// The flank as a heat map: root below, tip above, face I left. Canvas for the colours, SVG for the
// rest: axes, tooth grid, contours, extremes, the crosshair.
//
//     h(HeatMap, { name, summary, surface, limit, unit, axes, at, onAt })        a map to work with
//     h(HeatMap, { name, summary, surface, limit, unit, axes, small: true })     a small one, without axes

import { t } from "../i18n/flank.js";
import { fmt } from "../i18n/i18n.js";
import { Fragment, h, html, useId, useMemo, useRef } from "../../vendor/ui.js";
import { scaleOf, ticksOf } from "../charts/scale.js";
import { useWidth } from "../charts/chart.js";
import { contoursOf, levelsOf } from "./contours.js";
import { scaleLabel } from "./legend.js";
import { usePainting } from "./painting.js";
import { heightsOf, placeOf, toX, toY } from "./raster.js";
import { boxOf, extremesOf, nearestNode, nodeOf } from "./surface.js";

/** @typedef {import("./surface.js").FlankSurface} FlankSurface */
/** @typedef {import("./surface.js").FlankNode} FlankNode */
/** @typedef {import("./surface.js").Box} Box */
/** @typedef {{ label: string, unit?: string | undefined }} MapAxis */
/** @typedef {{ u: MapAxis, v: MapAxis }} MapAxes */

/** The same as of charts, so that adjacent sections align. */
export const MARGIN = { top: 12, right: 16, bottom: 44, left: 64 };
const NONE = { top: 0, right: 0, bottom: 0, left: 0 };
const MOST_LINES = 60;

/**
 * @typedef {object} HeatMapProps
 * @property {string} name
 * @property {string} summary a sentence that says what is to be seen
 * @property {FlankSurface} surface
 * @property {number} limit of the colours, on both sides of 0
 * @property {string | undefined} [unit] of the heights
 * @property {MapAxes} axes
 * @property {boolean} [flipU] the greatest u is at the root (internal gears)
 * @property {number} [height]
 * @property {boolean} [small] without axes and reading out
 * @property {Box | undefined} [window] the visible part; by default all
 * @property {Box | undefined} [range] evaluation range
 * @property {boolean} [percent] axes in per cent of `range`, or of all
 * @property {boolean} [lines] the tooth grid
 * @property {boolean} [contours]
 * @property {number} [density] pixels of the image for one of the page; 3 for print
 * @property {readonly import("../lib/exclude.js").NodeMark[]} [marks] nodes that are suspected or excluded
 * @property {{ u: number, v: number } | undefined} [at] the crosshair
 * @property {(node: FlankNode) => string} [says] reads a node out
 * @property {((node: FlankNode) => void) | undefined} [onAt] pointer and arrows choose a node
 * @property {((box: Box) => void) | undefined} [onWindow] a rectangle was drawn
 */

/** @param {HeatMapProps} props */
export function HeatMap(props) {
  const { name, summary, surface, limit, small = false, flipU = false, density } = props;
  const id = useId();
  const [holder, width] = useWidth();
  // on wide screens a map grows in both directions
  const height = props.height ?? (small ? 96 : Math.round(Math.min(560, Math.max(380, 0.36 * width))));
  const margin = small ? NONE : MARGIN;
  const whole = useMemo(() => boxOf(surface), [surface.u, surface.v]);
  const box = props.window ?? whole;
  const view = {
    width: Math.max(40, width - margin.left - margin.right),
    height: height - margin.top - margin.bottom,
    box,
    flipU,
  };
  const canvas = usePainting(
    { surface, view, limit, density: density ?? Math.min(2, globalThis.devicePixelRatio || 1) },
    [surface, view.width, view.height, box.u[0], box.u[1], box.v[0], box.v[1], limit, flipU, density],
  );
  const drawing = html`<div class=${`heat-map${small ? " small" : ""}`} ref=${holder}>
    <canvas ref=${canvas} aria-hidden="true"></canvas>
    <svg class="chart" width="100%" height=${height} viewBox=${`0 0 ${width} ${height}`} preserveAspectRatio="none"
      role=${props.onAt ? undefined : "img"} aria-hidden=${props.onAt ? "true" : undefined}
      aria-label=${props.onAt ? undefined : `${name}. ${summary}`}>
      <g transform=${`translate(${margin.left} ${margin.top})`}>${h(Overlay, { ...props, view, whole })}</g>
    </svg>
  </div>`;
  if (small || !props.onAt) return drawing;
  return html`<div>
    <p class="visually-hidden" id=${id}>${summary}</p>
    ${h(Pointer, { ...props, view, whole, describedBy: id, children: drawing })}
  </div>`;
}

/** @typedef {HeatMapProps & { view: import("./raster.js").View, whole: Box }} Seen */

/** @param {Seen} props */
function Overlay(props) {
  const { surface, limit, view, small = false, lines = false, contours = false, range } = props;
  const extremes = useMemo(() => extremesOf(surface), [surface]);
  const drawn = useMemo(
    () => (contours ? contoured(surface, view, limit) : null),
    [surface, limit, contours, view.width, view.height, view.box.u[0], view.box.u[1], view.box.v[0], view.box.v[1]],
  );
  const inside = (/** @type {{ u: number, v: number }} */ { u, v }) =>
    u >= view.box.u[0] && u <= view.box.u[1] && v >= view.box.v[0] && v <= view.box.v[1];
  return h(
    Fragment,
    null,
    lines && surface.kind === "grid" ? h(ToothGrid, { surface, view }) : null,
    drawn ? h(ContourLines, { drawn, view }) : null,
    range ? h(RangeFrame, { range, view }) : null,
    !small && extremes
      ? [
          ["least", extremes.least],
          ["greatest", extremes.greatest],
        ].map(([key, node]) => {
          const place = /** @type {FlankNode} */ (node);
          if (!inside(place)) return null;
          const at = `translate(${toX(view, place.v)} ${toY(view, place.u)})`;
          return html`<g key=${key} class="map-extreme" transform=${at}><circle class="ground" r="9" /><path d=${EXTREME[/** @type {"least"} */ (key)]} /></g>`;
        })
      : null,
    small ? null : h(MapAxesDrawn, props),
    (props.marks ?? []).map(({ index, kind }) => {
      const place = nodeOf(surface, index);
      if (!inside(place)) return null;
      const at = `translate(${toX(view, place.v)} ${toY(view, place.u)})`;
      return html`<g key=${`${kind}${index}`} class=${`map-mark ${kind}`} data-node=${index} transform=${at}>${kind === "excluded" ? html`<circle class="halo" r="6" /><circle r="6" />` : html`<path class="halo" d=${CROSS} /><path d=${CROSS} />`}</g>`;
    }),
    props.at && inside(props.at) ? h(Crosshair, { at: props.at, view }) : null,
  );
}

/** Triangles: up for the greatest, down for the least. */
const EXTREME = { least: "M-5.5 -3.5h11L0 6z", greatest: "M-5.5 3.5h11L0 -6z" };

/** Mark of a suspected node; an excluded node has a hollow circle. */
const CROSS = "M-6 -6L6 6M-6 6L6 -6";

/** @param {{ surface: import("./surface.js").Grid, view: import("./raster.js").View }} props */
function ToothGrid({ surface, view }) {
  const [u, v] = [thinned(surface.u), thinned(surface.v)];
  const across = u.map((value) => toY(view, value)).filter((y) => y >= 0 && y <= view.height);
  const up = v.map((value) => toX(view, value)).filter((x) => x >= 0 && x <= view.width);
  const [left, right] = ends(surface.v, (value) => toX(view, value), view.width);
  const [top, bottom] = ends(surface.u, (value) => toY(view, value), view.height);
  const path = [
    ...across.map((y) => `M${left} ${y.toFixed(1)}H${right}`),
    ...up.map((x) => `M${x.toFixed(1)} ${top}V${bottom}`),
  ];
  return html`<path class="map-grid" d=${path.join("")} />`;
}

/** @param {Float64Array} values @param {(value: number) => number} to @param {number} most */
function ends(values, to, most) {
  const found = [to(values[0] ?? 0), to(values.at(-1) ?? 0)].sort((a, b) => a - b);
  return found.map((one) => Math.min(most, Math.max(0, one)).toFixed(1));
}

/** @param {Float64Array} values */
function thinned(values) {
  const every = Math.ceil(values.length / MOST_LINES);
  return [...values].filter((_, i) => i % every === 0 || i === values.length - 1);
}

/** @param {{ range: Box, view: import("./raster.js").View }} props */
function RangeFrame({ range, view }) {
  const [x0, x1] = [toX(view, range.v[0]), toX(view, range.v[1])].sort((a, b) => a - b);
  const [y0, y1] = [toY(view, range.u[0]), toY(view, range.u[1])].sort((a, b) => a - b);
  if (x0 === undefined || x1 === undefined || y0 === undefined || y1 === undefined) return null;
  return ["map-range halo", "map-range"].map(
    (name) => html`<rect key=${name} class=${name} x=${x0} y=${y0} width=${x1 - x0} height=${y1 - y0} />`,
  );
}

/** @param {FlankSurface} surface @param {import("./raster.js").View} view @param {number} limit */
function contoured(surface, view, limit) {
  const step = Math.max(3, Math.ceil(Math.max(view.width, view.height) / 220));
  const [width, height] = [Math.max(2, Math.round(view.width / step)), Math.max(2, Math.round(view.height / step))];
  const heights = heightsOf(surface, { ...view, width, height });
  const [sx, sy] = [view.width / width, view.height / height];
  return contoursOf(heights, width, levelsOf(limit)).map(({ level, segments }) => ({
    level,
    segments: segments.map(
      ([x, y, p, q]) => /** @type {const} */ ([(x + 0.5) * sx, (y + 0.5) * sy, (p + 0.5) * sx, (q + 0.5) * sy]),
    ),
  }));
}

/** @param {{ drawn: ReturnType<typeof contoured>, view: import("./raster.js").View }} props */
function ContourLines({ drawn, view }) {
  /** @type {number[][]} */
  const taken = [];
  const labels = drawn.flatMap(({ level, segments }) => {
    // the piece with most space: away from labels and towards the middle of the line
    const piece = segments[Math.floor(segments.length / 2)];
    if (!piece || segments.length < 8) return [];
    const [x, y] = [(piece[0] + piece[2]) / 2, (piece[1] + piece[3]) / 2];
    if (
      x < 20 ||
      x > view.width - 20 ||
      y < 10 ||
      y > view.height - 10 ||
      taken.some(([px = 0, py = 0]) => Math.abs(px - x) < 34 && Math.abs(py - y) < 16)
    )
      return [];
    taken.push([x, y]);
    return [{ level, x, y }];
  });
  return html`<g class="map-contours">
    ${drawn.map(({ level, segments }) => {
      const d = segments.map((s) => `M${s[0].toFixed(1)} ${s[1].toFixed(1)}L${s[2].toFixed(1)} ${s[3].toFixed(1)}`);
      return html`<path key=${level} class=${level === 0 ? "zero" : ""} d=${d.join("")} />`;
    })}
    ${labels.map(({ level, x, y }) => html`<text key=${level} x=${x} y=${y} dy="0.35em" text-anchor="middle" translate="no">${scaleLabel(level)}</text>`)}
  </g>`;
}

/** @param {{ at: { u: number, v: number }, view: import("./raster.js").View }} props */
function Crosshair({ at, view }) {
  const [x, y] = [toX(view, at.v), toY(view, at.u)];
  return html`<g class="map-crosshair">
    <path class="halo" d=${`M${x} 0V${view.height}M0 ${y}H${view.width}`} />
    <path d=${`M${x} 0V${view.height}M0 ${y}H${view.width}`} /><circle cx=${x} cy=${y} r="5" />
  </g>`;
}

/** Per cent of a range. @param {number} value @param {readonly [number, number]} range */
export function percentOf(value, [from, to]) {
  return (100 * (value - from)) / (to - from || 1);
}

/** @param {Seen} props */
function MapAxesDrawn({ axes, view, range, whole, percent = false }) {
  const of = range ?? whole;
  const spec = (/** @type {"u" | "v"} */ axis) => ({
    ...axes[axis],
    ...(percent ? { unit: "%" } : {}),
    domain: percent
      ? /** @type {[number, number]} */ (view.box[axis].map((value) => percentOf(value, of[axis])))
      : view.box[axis],
  });
  const [u, v] = [spec("u"), spec("v")];
  const rising = view.flipU ? [0, view.height] : [view.height, 0];
  const [up, across] = [scaleOf(u, /** @type {[number, number]} */ (rising)), scaleOf(v, [0, view.width])];
  // a narrow map only has space for the sign of a face next to the title
  const narrow = view.width < 340;
  const title = (/** @type {MapAxis} */ { label, unit }) =>
    html`${label}${unit && html`<tspan translate="no">${` / ${unit}`}</tspan>`}`;
  return html`<g class="chart-axes">
    ${ticksOf(across, { ...v, ticks: view.width < 420 ? 4 : 8 }, fmt.value).map(
      ({ value, label }) =>
        html`<g key=${`v${value}`}><path class="frame" d=${`M${across(value)} ${view.height}v4`} /><text x=${across(value)} y=${view.height + 16} text-anchor="middle" translate="no">${label}</text></g>`,
    )}
    ${ticksOf(up, { ...u, ticks: 6 }, fmt.value).map(
      ({ value, label }) =>
        html`<g key=${`u${value}`}><path class="frame" d=${`M0 ${up(value)}h-4`} /><text x="-8" y=${up(value)} dy="0.35em" text-anchor="end" translate="no">${label}</text></g>`,
    )}
    <path class="frame" d=${`M0 0V${view.height}H${view.width}V0z`} />
    <text class="axis-title" x=${view.width / 2} y=${view.height + 36} text-anchor="middle">${title(v)}</text>
    <text x="0" y=${view.height + 36} text-anchor="start">${narrow ? t.shortI : t.faceI}</text>
    <text x=${view.width} y=${view.height + 36} text-anchor="end">${narrow ? t.shortII : t.faceII}</text>
    <text class="axis-title" transform=${`translate(${-MARGIN.left + 14} ${view.height / 2}) rotate(-90)`} text-anchor="middle">${title(u)}</text>
    <text transform=${`translate(${-MARGIN.left + 14} ${view.height}) rotate(-90)`} text-anchor="start">${t.root}</text>
    <text transform=${`translate(${-MARGIN.left + 14} 0) rotate(-90)`} text-anchor="end">${t.tip}</text>
  </g>`;
}

/** A height with its unit. @param {number} z @param {string | undefined} unit @param {number} limit of the scale */
export const heightText = (z, unit, limit) => `${fmt.value.onScale(z, limit, unit)}${unit ? ` ${unit}` : ""}`;

/** A place on an axis with its unit. @param {number} at @param {MapAxis} axis @param {readonly [number, number]} range of the axis */
export const placeText = (at, { unit }, [from, to]) =>
  `${fmt.value.onScale(at, to - from, "mm")}${unit ? ` ${unit}` : ""}`;

/** Describes a node as text. @param {FlankNode} node @param {{ axes: MapAxes, unit?: string | undefined, whole: Box, range?: Box | undefined, limit: number }} context */
export function nodeText(node, { axes, unit, whole, range, limit }) {
  const of = range ?? whole;
  const part = (/** @type {"u" | "v"} */ axis) =>
    `${axes[axis].label} ${placeText(node[axis], axes[axis], whole[axis])} (${fmt.value.fixed(percentOf(node[axis], of[axis]), 0)} %)`;
  const height = Number.isNaN(node.z) ? t.missing : heightText(node.z, unit, limit);
  const place =
    node.row === undefined || node.column === undefined ? "" : ` · ${t.cell(node.row + 1, node.column + 1)}`;
  return `${part("u")} · ${part("v")} · ${height}${place}`;
}

/** @param {Seen & { describedBy: string, children: import("../../vendor/ui.js").ComponentChildren }} props */
function Pointer(props) {
  const { name, surface, view, at, onAt, onWindow, whole, describedBy, children } = props;
  const pressed = useRef(/** @type {{ u: number, v: number, x: number, y: number } | null} */ (null));
  const middle = { u: (whole.u[0] + whole.u[1]) / 2, v: (whole.v[0] + whole.v[1]) / 2 };
  const node = useMemo(
    () => nearestNode(surface, at?.u ?? middle.u, at?.v ?? middle.v),
    [surface, at?.u, at?.v, whole],
  );
  const placed = (/** @type {PointerEvent & { currentTarget: Element }} */ event) => {
    const box = event.currentTarget.getBoundingClientRect();
    const [x, y] = [event.clientX - box.left - MARGIN.left, event.clientY - box.top - MARGIN.top];
    return { ...placeOf(view, x, y), x, y };
  };
  const step = (/** @type {number} */ du, /** @type {number} */ dv) => {
    const sign = view.flipU ? -1 : 1;
    if (surface.kind === "grid" && node.row !== undefined && node.column !== undefined) {
      const row = Math.min(surface.u.length - 1, Math.max(0, node.row + sign * du));
      const column = Math.min(surface.v.length - 1, Math.max(0, node.column + dv));
      return nodeOf(surface, row * surface.v.length + column);
    }
    const [u, v] = [view.box.u[1] - view.box.u[0], view.box.v[1] - view.box.v[0]];
    return nearestNode(surface, node.u + (sign * du * u) / 24, node.v + (dv * v) / 24);
  };
  const press = (/** @type {KeyboardEvent} */ event) => {
    const moves = /** @type {Record<string, [number, number]>} */ ({
      ArrowUp: [1, 0],
      ArrowDown: [-1, 0],
      ArrowRight: [0, 1],
      ArrowLeft: [0, -1],
      PageUp: [5, 0],
      PageDown: [-5, 0],
      Home: [0, -1e9],
      End: [0, 1e9],
    });
    const move = moves[event.key];
    if (!move) return;
    event.preventDefault();
    onAt?.(at ? step(...move) : node);
  };
  const release = (/** @type {PointerEvent & { currentTarget: Element }} */ event) => {
    const [from, to] = [pressed.current, placed(event)];
    pressed.current = null;
    if (!from || !onWindow || Math.abs(from.x - to.x) < 12 || Math.abs(from.y - to.y) < 12) return;
    onWindow({ u: sorted(from.u, to.u, whole.u), v: sorted(from.v, to.v, whole.v) });
  };
  return html`<div class="chart-reader" tabindex="0" role="slider" aria-label=${name} aria-describedby=${describedBy}
    aria-valuemin="1" aria-valuemax=${surface.z.length} aria-valuenow=${node.index + 1} aria-valuetext=${props.says?.(node)}
    onKeyDown=${press}
    onPointerDown=${(/** @type {PointerEvent & { currentTarget: Element }} */ event) => {
      const place = placed(event);
      pressed.current = place;
      onAt?.(nearestNode(surface, place.u, place.v));
    }}
    onPointerUp=${release} onPointerLeave=${() => {
      pressed.current = null;
    }}>${children}</div>`;
}

/** @param {number} a @param {number} b @param {readonly [number, number]} whole @returns {[number, number]} */
function sorted(a, b, [low, high]) {
  return [Math.max(low, Math.min(a, b)), Math.min(high, Math.max(a, b))];
}
