// The colour scale of a map: a bar from −limit to limit, and the number of heights outside it.

import { t } from "../i18n/flank.js";
import { fmt } from "../i18n/i18n.js";
import { css, deviationColour } from "../lib/colour.js";
import { html, useId } from "../../vendor/ui.js";

const STEPS = 48;

/** Formats a number of a scale with all its digits: half of 5 is 2.5. @param {number} value */
export const scaleLabel = (value) =>
  value !== 0 && Math.abs(value) < 1e-3
    ? fmt.value.significant(value, 2)
    : fmt.value.input(Number(value.toPrecision(6))).replace("-", "\u2212");

/**
 * @param {{ limit: number, unit?: string | undefined, clipped?: number, missing?: number, small?: boolean }} props
 *   `clipped`: number of heights outside the scale
 */
export function Legend({ limit, unit, clipped = 0, missing = 0, small = false }) {
  const id = useId();
  const marks = small ? [-1, 0, 1] : [-1, -0.5, 0, 0.5, 1];
  return html`<div class="map-legend">
    <svg class="chart" viewBox="0 0 240 34" width="240" height="34" aria-hidden="true">
      ${Array.from({ length: STEPS }, (_, i) => {
        const colour = css(deviationColour((2 * (i + 0.5)) / STEPS - 1, 1));
        return html`<rect key=${i} x=${20 + (200 * i) / STEPS} y="2" width=${200 / STEPS + 0.5} height="12" fill=${colour} stroke="none" />`;
      })}
      ${marks.map((mark) => html`<text key=${mark} x=${120 + 100 * mark} y="29" text-anchor="middle" translate="no">${scaleLabel(mark * limit)}</text>`)}
    </svg>
    <p class="hint" id=${id}>
      ${unit && html`<span translate="no">${unit}</span> · `}${t.materialOut}${clipped > 0 && html` · ${t.clipped(clipped)}`}
      ${missing > 0 && html` · <span class="hatch-sample" aria-hidden="true"></span> ${t.missingNodes(missing)}`}
    </p>
  </div>`;
}
