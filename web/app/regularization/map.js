// The residuals of a refit, or its fitted flank, as a small map that follows the slider.

import { useAsTable } from "../components/as_table.js";
import { SelectField } from "../components/form.js";
import { extremesOf } from "../flank/surface.js";
import { HeatMap } from "../flank/heat_map.js";
import { atNodes } from "../flank/layers.js";
import { Legend } from "../flank/legend.js";
import { mapAxes } from "../flank/axes.js";
import { MapTable } from "../flank/map_table.js";
import { scaleFor } from "../flank/scale.js";
import { t as common } from "../i18n/common.js";
import de from "../i18n/de/lambda.js";
import en from "../i18n/en/lambda.js";
import { fmt, texts } from "../i18n/i18n.js";
import { heightUnit } from "../lib/units.js";
import { query, setQuery } from "../navigation.js";
import { h, html, useMemo } from "../../vendor/ui.js";

/** @typedef {import("../api/client.js").Schema<"Residuals">} Residuals */

const t = texts({ en, de });

/** The number of nodes up to which the map follows each move of the slider; above it, the map follows on release. */
export const FOLLOWED = 5000;

/** @returns {"residual" | "fitted"} */
export const shownLayer = () => (query.value.get("layer") === "fitted" ? "fitted" : "residual");

/** Returns the parts of a response that the map needs. @param {"residual" | "fitted"} layer @returns {("residuals" | "fitted")[]} */
export const includedFor = (layer) => [layer === "fitted" ? "fitted" : "residuals"];

/**
 * @param {{ measured: import("../flank/surface.js").FlankSurface | undefined, residuals: Residuals | undefined, axes: import("../flank/axes.js").Axes | null | undefined,
 *   flipU: boolean, refit: boolean, many: boolean }} props `measured`, `residuals`: of what is shown, once they are there; `many`: it follows when the
 *   slider is let go
 */
export function RefitMap({ measured, residuals, axes, flipU, refit, many }) {
  const layer = shownLayer();
  const values = layer === "fitted" ? residuals?.fitted : residuals?.values;
  const surface = useMemo(
    () => (measured && values ? atNodes(measured, values, residuals?.node_indices) : undefined),
    [measured, values],
  );
  const unit = heightUnit(axes) ?? common.callersUnit;
  const name = `${t[layer]}, ${refit ? t.refit : t.thisFit}`;
  const ends = surface && extremesOf(surface);
  const scale = surface && scaleFor(surface);
  const write = (/** @type {number} */ z) => `${fmt.value.onScale(z, scale?.limit ?? 0, unit)}\u202f${unit}`;
  const summary = ends ? t.mapSummary(write(ends.least.z), write(ends.greatest.z)) : "";
  const { asTable, button } = useAsTable(name);
  return html`<section class="panel lambda-map" aria-labelledby="lambda-map" data-refit=${refit ? "1" : undefined}>
    <header>
      <h2 id="lambda-map">${t.map}</h2>
      <div class="lambda-map-tools">
        ${h(SelectField, {
          label: t.layer,
          required: true,
          value: layer,
          options: /** @type {const} */ (["residual", "fitted"]).map((one) => ({ value: one, label: t[one] })),
          onChange: (value) => setQuery({ layer: value === "fitted" ? value : undefined }, { step: true }),
        })}
        ${button}
      </div>
    </header>
    ${
      surface && scale
        ? html`<p class="quiet" data-extremes translate="no">${summary}</p>
            ${
              asTable
                ? h(MapTable, { surface, title: t[layer], name, unit, axes: mapAxes(axes), csvName: `lambda-${layer}` })
                : html`${h(HeatMap, { name, summary, surface, limit: scale.limit, unit, axes: mapAxes(axes), flipU, height: 260 })}
                    ${h(Legend, { limit: scale.limit, unit, clipped: scale.clipped })}`
            }`
        : html`<div class="lambda-map-place"></div>`
    }
    ${many && html`<p class="hint">${t.mapOnRelease}</p>`}
  </section>`;
}
