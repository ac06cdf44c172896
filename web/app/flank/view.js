// A layer of the flank to work with: map, adjacent sections, scale, zoom, files.

import { Chart } from "../charts/chart.js";
import { Line, Rule } from "../charts/marks.js";
import { Menu } from "../components/dialog.js";
import { SelectField } from "../components/form.js";
import { Later } from "../components/later.js";
import { TABLET, useMedia } from "../components/media.js";
import { Empty } from "../components/states.js";
import { t as common } from "../i18n/common.js";
import { t } from "../i18n/flank.js";
import { fmt } from "../i18n/i18n.js";
import { niceAbove, stepsBetween } from "../lib/colour.js";
import { csv, download } from "../lib/csv.js";
import { query, setQuery } from "../navigation.js";
import { useShortcut } from "../components/shortcuts.js";
import { h, html, useMemo } from "../../vendor/ui.js";
import { mapAxes } from "./axes.js";
import { HeatMap, heightText, nodeText, placeText } from "./heat_map.js";
import { Legend, scaleLabel } from "./legend.js";
import { MapTable } from "./map_table.js";
import { pngOf } from "./png.js";
import { clippedBy, scaleFor } from "./scale.js";
import { Flank3d, hasWebgl } from "./view_3d.js";
import { boxOf, countsOf, extremesOf, nearestNode, nodeOf, sectionOf } from "./surface.js";

/** @typedef {import("./surface.js").FlankSurface} FlankSurface */
/** @typedef {import("./surface.js").Box} Box */

/**
 * @typedef {object} FlankViewProps
 * @property {FlankSurface} surface
 * @property {string} title of the layer
 * @property {string} name
 * @property {string | undefined} unit of the heights
 * @property {import("../api/client.js").Schema<"Axes"> | null | undefined} axes
 * @property {{ u?: unknown, v?: unknown } | null | undefined} [range] evaluation range
 * @property {boolean} [flipU]
 * @property {readonly import("../lib/exclude.js").NodeMark[]} [marks]
 * @property {((index: number) => import("../../vendor/ui.js").ComponentChildren) | undefined} [action] the action for the node that is read out
 * @property {string} file name of what is saved, without its end
 * @property {string} [about] part, flank and date, for saved pictures
 * @property {number} [atLeast] least limit of an automatic scale, so that maps can be compared
 */

/** @param {FlankViewProps} props */
export function FlankView(props) {
  const {
    surface,
    title,
    name,
    unit,
    axes: givenAxes,
    range: givenRange,
    flipU = false,
    marks,
    action,
    file,
    about = "",
    atLeast = 0,
  } = props;
  const tablet = useMedia(TABLET);
  const axes = mapAxes(givenAxes);
  const whole = useMemo(() => boxOf(surface), [surface.u, surface.v]);
  const automatic = Math.max(scaleFor(surface).limit, atLeast);
  const extremes = useMemo(() => extremesOf(surface), [surface]);
  const counts = useMemo(() => countsOf(surface), [surface]);
  const range = rangeOf(givenRange) ?? whole;
  const fixed = Number(query.value.get("limit"));
  const limit = fixed > 0 && Number.isFinite(fixed) ? fixed : automatic;
  const clipped = useMemo(() => clippedBy(surface, limit), [surface, limit]);
  const window = windowOf(query.value.get("zoom"), whole);
  const flag = (/** @type {string} */ key) => query.value.get(key) === "1";
  const percent = flag("percent");
  const inSpace = flag("space");
  const drawable = useMemo(() => inSpace && hasWebgl(), [inSpace]);
  const given = pair(query.value.get("at"));
  const node = useMemo(() => {
    const [u, v] = given ?? [(whole.u[0] + whole.u[1]) / 2, (whole.v[0] + whole.v[1]) / 2];
    return nearestNode(surface, u, v);
  }, [surface, query.value.get("at")]);
  const zoom = (/** @type {number} */ factor) => setWindow(zoomed(window ?? whole, whole, node, factor), whole);
  useShortcut(
    "+",
    () => t.zoomIn,
    () => zoom(0.5),
  );
  useShortcut(
    "-",
    () => t.zoomOut,
    () => zoom(2),
  );
  useShortcut(
    "0",
    () => t.zoomReset,
    () => setQuery({ zoom: undefined }),
  );
  if (!extremes) return h(Empty, { children: t.noHeights });
  const says = (/** @type {import("./surface.js").FlankNode} */ one) =>
    nodeText(one, { axes, unit, whole, range, limit: Math.min(limit, automatic) });
  const summary = t.extremes(says(extremes.least), says(extremes.greatest));
  const save = async () => {
    const marks = { root: t.root, tip: t.tip, faceI: t.faceI, faceII: t.faceII, material: t.materialOut };
    const blob = await pngOf({
      title: name,
      about,
      contours: flag("contours"),
      surface,
      limit,
      unit,
      axes,
      flipU,
      marks,
      ...(window ? { box: window } : {}),
    });
    download(`${file}.png`, blob);
  };
  const toggle = (/** @type {string} */ key, /** @type {string} */ label) =>
    html`<button type="button" class="button small" aria-pressed=${flag(key)} onClick=${() => setQuery({ [key]: flag(key) ? undefined : 1 })}>${label}</button>`;
  const toggles = html`${toggle("space", t.inSpace)}${toggle("lines", t.toothGrid)}${toggle("contours", t.contours)}${toggle("percent", t.percent)}${toggle("table", common.asTable)}`;
  const files = html`<button type="button" class="button small" onClick=${save}>${t.png}</button>
    <button type="button" class="button small" onClick=${() => saveCsv(file, surface, axes, title, unit)}>${common.csv}</button>`;
  return html`<div class="flank-view">
    <div class="flank-tools">
      ${tablet ? h(Menu, { label: t.tools, children: html`${toggles}${files}` }) : html`<div class="actions">${toggles}</div>`}
      <div class="actions end">
        <button type="button" class="button small" aria-label=${t.zoomIn} onClick=${() => zoom(0.5)}>+</button>
        <button type="button" class="button small" aria-label=${t.zoomOut} disabled=${!window} onClick=${() => zoom(2)}>−</button>
        ${window && html`<button type="button" class="button small" onClick=${() => setQuery({ zoom: undefined })}>${t.zoomReset}</button>`}
        ${!tablet && files}
      </div>
    </div>
    <div class="flank-layout">
      <div class="flank-map">
        ${
          flag("table")
            ? h(MapTable, { surface, title, name, unit, axes, csvName: file })
            : inSpace && drawable
              ? h(Flank3d, {
                  surface,
                  limit,
                  unit,
                  name,
                  summary,
                  flipU,
                  at: given ? node : undefined,
                  onAt: (one) => setQuery({ at: `${one.u},${one.v}` }),
                  says,
                })
              : h(HeatMap, {
                  name,
                  summary,
                  surface,
                  limit,
                  unit,
                  axes,
                  flipU,
                  range,
                  percent,
                  window,
                  lines: flag("lines"),
                  contours: flag("contours"),
                  ...(marks ? { marks } : {}),
                  at: given ? node : undefined,
                  says,
                  onAt: (one) => setQuery({ at: `${one.u},${one.v}` }),
                  onWindow: (box) => setWindow(box, whole),
                })
        }
        ${inSpace && !drawable && html`<p class="hint" role="status">${t.noWebgl}</p>`}
        <div class="map-node">
          ${!drawable && html`<p class="chart-readout" aria-hidden="true" translate="no">${given ? says(node) : "\u00a0"}</p>`}
          ${given && action?.(node.index)}
        </div>
        <div class="flank-scale">
          ${h(Legend, { limit, unit, clipped, missing: counts.missing })}
          ${h(SelectField, {
            label: t.limit,
            required: true,
            value: fixed > 0 ? String(fixed) : "",
            options: [
              { value: "", label: t.automatic },
              ...limits(automatic, fixed).map((one) => ({ value: String(one), label: `±${scaleLabel(one)}` })),
            ],
            onChange: (value) => setQuery({ limit: value }),
          })}
          <dl class="map-extremes">
            <div><dt><svg viewBox="-8 -8 16 16" width="14" height="14" aria-hidden="true"><path class="filled" d="M-6 -5h12L0 6z" /></svg> ${t.least}</dt><dd data-extreme="least" translate="no">${says(extremes.least)}</dd></div>
            <div><dt><svg viewBox="-8 -8 16 16" width="14" height="14" aria-hidden="true"><path class="filled" d="M-6 5h12L0 -6z" /></svg> ${t.greatest}</dt><dd data-extreme="greatest" translate="no">${says(extremes.greatest)}</dd></div>
          </dl>
        </div>
      </div>
      ${h(Later, { place: "section-place", children: () => h(Section, { kind: "profile", surface, axes, unit, limit, at: node.v, file, whole, domain: (window ?? whole).u }) })}
      ${h(Later, { place: "section-place", children: () => h(Section, { kind: "helix", surface, axes, unit, limit, at: node.u, file, whole, domain: (window ?? whole).v }) })}
    </div>
  </div>`;
}

/**
 * @param {{ kind: "profile" | "helix", surface: FlankSurface, axes: import("./heat_map.js").MapAxes, unit: string | undefined,
 *   limit: number, at: number, file: string, whole: Box, domain: readonly [number, number] }} props
 */
function Section({ kind, surface, axes, unit, limit, at, file, whole, domain }) {
  const all = useMemo(() => sectionOf(surface, kind, at), [surface, kind, at]);
  const points = all.filter(({ x }) => x >= domain[0] && x <= domain[1]);
  const [x, other] = kind === "profile" ? /** @type {const} */ (["u", "v"]) : /** @type {const} */ (["v", "u"]);
  const [along, across] = [axes[x], axes[other]];
  const there = points.filter(({ y }) => Number.isFinite(y));
  const most = Math.max(limit, niceAbove(there.reduce((size, { y }) => Math.max(size, Math.abs(y)), 0)));
  const place = `${across.label} ${placeText(at, across, whole[other])}`;
  return h(Chart, {
    name: kind === "profile" ? t.profile : t.helix,
    summary: place,
    height: 230,
    x: { ...along, domain },
    y: { label: t.deviation, unit, domain: [-most, most] },
    probes: there.map(({ x, y }) => ({
      x,
      y,
      text: `${placeText(x, along, domain)}: ${heightText(y, unit, most)}`,
    })),
    data: {
      columns: [
        {
          key: "x",
          header: along.label,
          unit: along.unit,
          numeric: true,
          cell: ({ x }) => html`<span translate="no">${fmt.value.onScale(x, domain[1] - domain[0], "mm")}</span>`,
          csv: ({ x }) => x,
        },
        {
          key: "y",
          header: t.deviation,
          unit,
          numeric: true,
          cell: ({ y }) => html`<span translate="no">${fmt.value.onScale(y, most, unit)}</span>`,
          csv: ({ y }) => y,
        },
      ],
      rows: points.slice(0, 2000),
      rowKey: ({ x }) => x,
      csvName: `${file}-${kind}`,
    },
    children: (plot) => html`${h(Rule, { plot, y: 0, kind: "zero" })}${h(Line, { plot, points })}`,
  });
}

/** @param {FlankViewProps["range"]} range @returns {Box | undefined} */
function rangeOf(range) {
  const part = (/** @type {unknown} */ one) =>
    Array.isArray(one) && one.length === 2 && one.every(Number.isFinite)
      ? /** @type {[number, number]} */ ([one[0], one[1]])
      : undefined;
  const [u, v] = [part(range?.u), part(range?.v)];
  return u && v ? { u, v } : undefined;
}

/** @param {string | null} text @returns {[number, number] | undefined} */
function pair(text) {
  const [a, b, more] = (text ?? "").split(",").map((part) => (part === "" ? Number.NaN : Number(part)));
  return a !== undefined && b !== undefined && more === undefined && Number.isFinite(a + b) ? [a, b] : undefined;
}

/** @param {string | null} text @param {Box} whole @returns {Box | undefined} */
function windowOf(text, whole) {
  const [a = Number.NaN, b = Number.NaN, c = Number.NaN, d = Number.NaN] = (text ?? "").split(",").map(Number);
  if (!(a < b && c < d) || b < whole.u[0] || a > whole.u[1] || d < whole.v[0] || c > whole.v[1]) return undefined;
  return { u: [a, b], v: [c, d] };
}

/** @param {Box} box @param {Box} whole */
function setWindow({ u, v }, whole) {
  const all = u[0] <= whole.u[0] && u[1] >= whole.u[1] && v[0] <= whole.v[0] && v[1] >= whole.v[1];
  setQuery({ zoom: all ? undefined : [...u, ...v].map((one) => Number(one.toPrecision(7))).join(",") });
}

/** @param {Box} box @param {Box} whole @param {{ u: number, v: number }} at @param {number} factor @returns {Box} */
function zoomed(box, whole, at, factor) {
  const part = (/** @type {"u" | "v"} */ axis) => {
    const [low, high] = whole[axis];
    const width = Math.max((high - low) / 64, Math.min(high - low, factor * (box[axis][1] - box[axis][0])));
    const from = Math.min(high - width, Math.max(low, at[axis] - width / 2));
    return /** @type {[number, number]} */ ([from, from + width]);
  };
  return { u: part("u"), v: part("v") };
}

/** Selectable limits around the automatic one. @param {number} suited @param {number} fixed */
function limits(suited, fixed) {
  const near = stepsBetween(suited / 8, suited * 4);
  return [...new Set(fixed > 0 ? [...near, fixed] : near)].sort((a, b) => a - b);
}

/** @param {string} file @param {FlankSurface} surface @param {import("./heat_map.js").MapAxes} axes @param {string} title @param {string | undefined} unit */
function saveCsv(file, surface, axes, title, unit) {
  const unitOf = (/** @type {string | undefined} */ sign) => (sign ? { unit: sign } : {});
  /** @type {import("../lib/csv.js").CsvColumn<import("./surface.js").FlankNode>[]} */
  const columns = [
    { header: axes.u.label, ...unitOf(axes.u.unit), value: ({ u }) => u },
    { header: axes.v.label, ...unitOf(axes.v.unit), value: ({ v }) => v },
    { header: title, ...unitOf(unit), value: ({ z }) => z },
  ];
  const nodes = Array.from(surface.z, (_, i) => nodeOf(surface, i));
  download(`${file}.csv`, csv(columns, nodes, fmt.value.locale));
}
