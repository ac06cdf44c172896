// The maps of a report: small ones for the first page, whole ones at 300 dots an inch.

import { mapAxes } from "../flank/axes.js";
import { HeatMap } from "../flank/heat_map.js";
import { atNodes } from "../flank/layers.js";
import { Legend } from "../flank/legend.js";
import { clippedBy, commonScale } from "../flank/scale.js";
import { countsOf, extremesOf } from "../flank/surface.js";
import { t as common } from "../i18n/common.js";
import { t as flank } from "../i18n/flank.js";
import { fmt } from "../i18n/i18n.js";
import { t } from "../i18n/report.js";
import { heightUnit } from "../lib/units.js";
import { isPair } from "./pairs.js";
import { h, html } from "../../vendor/ui.js";

/** @typedef {import("./data.js").ReportData} ReportData */
/** @typedef {import("../flank/surface.js").FlankSurface} FlankSurface */
/** @typedef {{ data: ReportData, surface: FlankSurface }} Mapped */

/** Dots of the image per pixel of the page, of which an inch has 96. */
const DENSITY = 300 / 96;

/** Returns one scale for all of them. @param {readonly Mapped[]} mapped */
const scaleOf = (mapped) => commonScale(mapped.map(({ surface }) => surface));

/** Measured deviations, side by side. @param {{ data: readonly ReportData[], flipU: boolean }} props */
export function SmallMaps({ data, flipU }) {
  const mapped = data.flatMap((one) => (one.surface ? [{ data: one, surface: one.surface }] : []));
  if (mapped.length === 0) return null;
  const pair = isPair(data) && mapped.length > 1;
  // heights of different units have no common scale
  const units = new Set(mapped.map(({ data: one }) => heightUnit(one.iteration.axes)));
  const whole = units.size === 1 ? scaleOf(mapped) : undefined;
  return html`<div class="report-small">
    <div class="report-pair">
      ${mapped.map((one, i) => {
        const { number } = one.data.iteration;
        const name = !pair ? nameOf(one.data) : i === 0 ? t.before(number) : t.after(number);
        const { limit, clipped } = whole ?? scaleOf([one]);
        return html`<figure key=${number}>
          <figcaption>${name}</figcaption>
          ${h(HeatMap, { name, summary: summaryOf(one.surface), surface: one.surface, limit, axes: mapAxes(one.data.iteration.axes), small: true, contours: true, height: 78, flipU, density: DENSITY })}
          <p class="map-ends" aria-hidden="true"><span>${flank.faceI}</span><span>${flank.faceII}</span></p>
          ${!whole && h(Legend, { limit, unit: unitOf(one), clipped, missing: countsOf(one.surface).missing })}
        </figure>`;
      })}
    </div>
    ${whole && mapped[0] && h(Legend, { limit: whole.limit, unit: unitOf(mapped[0]), clipped: whole.clipped, missing: mapped.reduce((sum, { surface }) => sum + countsOf(surface).missing, 0) })}
  </div>`;
}

/** Measured and residual maps of each iteration. @param {{ data: readonly ReportData[], flipU: boolean }} props */
export function Maps({ data, flipU }) {
  const measured = data.flatMap((one) => (one.surface ? [{ data: one, surface: one.surface }] : []));
  const residual = data.flatMap((one) => {
    const residuals = one.fit?.result.residuals;
    return one.surface && residuals?.values
      ? [{ data: one, surface: atNodes(one.surface, residuals.values, residuals.node_indices) }]
      : [];
  });
  const none = data.filter(({ surface }) => !surface);
  return html`
    ${measured.length > 0 && html`<p class="quiet">${t.oneScale}</p>`}
    ${none.map(({ iteration }) => html`<p key=${iteration.number}>${common.iteration(iteration.number)}: ${t.noMap}</p>`)}
    ${drawn(measured, t.measuredMap, flipU)}${drawn(residual, t.residualMap, flipU)}`;
}

/** @param {readonly Mapped[]} mapped @param {string} kind @param {boolean} flipU */
function drawn(mapped, kind, flipU) {
  const units = new Set(mapped.map(unitOf));
  const whole = units.size === 1 ? scaleOf(mapped) : undefined;
  return mapped.map((one) => {
    const { iteration, fit } = one.data;
    const name = `${kind}, ${common.iteration(iteration.number)}`;
    const { limit } = whole ?? scaleOf([one]);
    const clipped = clippedBy(one.surface, limit);
    return html`<figure key=${name} class="report-map">
      <figcaption><h3>${name}</h3><p class="quiet">${summaryOf(one.surface)}</p></figcaption>
      ${h(HeatMap, { name, summary: summaryOf(one.surface), surface: one.surface, limit, unit: unitOf(one), axes: mapAxes(iteration.axes), range: fit?.result.domain?.v ? boxOf(fit.result.domain) : undefined, contours: true, height: 330, flipU, density: DENSITY })}
      ${h(Legend, { limit, unit: unitOf(one), clipped, missing: countsOf(one.surface).missing })}
    </figure>`;
  });
}

/** @param {Mapped} mapped */
function unitOf({ data }) {
  return heightUnit(data.iteration.axes) ?? common.callersUnit;
}

/** Returns the domain of the model. @param {import("../api/client.js").Schema<"Domain">} domain @returns {import("../flank/surface.js").Box | undefined} */
function boxOf({ u, v }) {
  const [u0, u1, v0, v1] = [...(u ?? []), ...(v ?? [])];
  if (u0 === undefined || u1 === undefined || v0 === undefined || v1 === undefined) return undefined;
  return { u: [u0, u1], v: [v0, v1] };
}

/** @param {FlankSurface} surface */
function summaryOf(surface) {
  const ends = extremesOf(surface);
  if (!ends) return flank.noHeights;
  const place = (/** @type {import("../flank/surface.js").FlankNode} */ { u, v, z }) =>
    `u ${fmt.value.mm(u)}, v ${fmt.value.mm(v)}: ${fmt.value.three(z)}`;
  return flank.extremes(place(ends.least), place(ends.greatest));
}

/** Names an iteration with its flank. @param {ReportData} data */
export function nameOf({ iteration: { number, flank, tooth } }) {
  const parts = [common.iteration(number), flank && t[flank], tooth];
  return parts.filter(Boolean).join(", ");
}
