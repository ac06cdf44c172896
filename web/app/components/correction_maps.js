// Deviations before a correction, as predicted and as measured after it: three maps on one scale.

import { mapAxes } from "../flank/axes.js";
import { HeatMap } from "../flank/heat_map.js";
import { hasDatum, ofCorrection, surfaceOf } from "../flank/layers.js";
import { Legend } from "../flank/legend.js";
import { MapTable } from "../flank/map_table.js";
import { commonScale } from "../flank/scale.js";
import { countsOf, extremesOf, withHeights } from "../flank/surface.js";
import { t } from "../i18n/correction.js";
import { t as flank } from "../i18n/flank.js";
import { fmt } from "../i18n/i18n.js";
import { micrometres } from "../lib/units.js";
import { h, html } from "../../vendor/ui.js";
import { useAsTable } from "./as_table.js";

/** @typedef {import("../flank/surface.js").FlankSurface} FlankSurface */
/** @typedef {import("../api/client.js").Schema<"Nodes">} Nodes */
/** @typedef {import("../api/client.js").Schema<"Correction">} Correction */
/** @typedef {import("../api/client.js").Schema<"Axes">} Axes */

/** @param {{ nodes: Nodes, axes: Axes | null | undefined, kept: Correction, paper?: boolean }} props `paper`: at 300 dots an inch, with lines that are seen in grey */
export function CorrectionMaps({ nodes, axes, kept, paper = false }) {
  const measured = surfaceOf(nodes);
  if (!measured) return html`<p class="quiet">${t.noMaps}</p>`;
  // corrections are in µm, + = material out; heights of unknown meaning are taken as such
  const factor = micrometres(axes) ?? 1;
  const before = withHeights(
    measured,
    measured.z.map((z) => factor * z),
  );
  const at = (/** @type {readonly (number | null)[] | null | undefined} */ values) =>
    values
      ? withHeights(
          before,
          Float64Array.from(values, (value) => value ?? Number.NaN),
        )
      : undefined;
  const maps = [
    { title: t.before, surface: before },
    { title: t.predicted, surface: at(kept.answer?.predicted_um ?? kept.result.predicted.deviation_um) },
    { title: t.measured, surface: at(kept.answer?.measured_um) },
  ].flatMap(({ title, surface }) => (surface ? [{ title, surface: ofCorrection(surface, kept) }] : []));
  const { limit, clipped } = commonScale(maps.map(({ surface }) => surface));
  const { missing } = countsOf(before);
  return html`<div class="maps">
      ${maps.map(({ title, surface }) =>
        h(DeviationMap, { key: title, title, surface, limit, axes: mapAxes(axes), paper }),
      )}
    </div>
    ${h(Legend, { limit, unit: "µm", clipped, missing })}
    ${!hasDatum(kept) && html`<p class="hint">${t.withoutMean}</p>`}`;
}

/** @param {{ title: string, surface: FlankSurface, limit: number, axes: import("../flank/heat_map.js").MapAxes, paper: boolean }} props */
function DeviationMap({ title, surface, limit, axes, paper }) {
  const { asTable, button } = useAsTable(title);
  return html`<figure>
    <figcaption>
      <div class="map-head"><h3>${title}</h3>${!paper && button}</div>
      <p class="quiet">${summaryOf(surface, limit)}</p>
    </figcaption>
    ${
      asTable
        ? h(MapTable, { surface, title: flank.deviation, name: title, unit: "µm", axes, csvName: title })
        : html`${h(HeatMap, {
            name: title,
            summary: summaryOf(surface, limit),
            surface,
            limit,
            unit: "µm",
            axes,
            small: true,
            height: 190,
            ...(paper ? { contours: true, density: 300 / 96 } : {}),
          })}
          <p class="map-ends hint" aria-hidden="true"><span>${flank.faceI}</span><span>${flank.faceII}</span></p>`
    }
  </figure>`;
}

/** @param {FlankSurface} surface @param {number} limit of the scale */
function summaryOf(surface, limit) {
  const ends = extremesOf(surface);
  const height = (/** @type {number | undefined} */ z) => fmt.value.onScale(z, limit, "µm");
  return t.mapSummary(height(ends?.least.z), height(ends?.greatest.z));
}
