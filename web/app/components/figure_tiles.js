// Tiles with the figures of a flank, their limits, and marks for within or outside.

import { fmt } from "../i18n/i18n.js";
import { t } from "../i18n/requirements.js";
import { h, html } from "../../vendor/ui.js";
import { limitText, figureRows } from "./flank_figures.js";
import { GearSymbol } from "./symbol.js";
import { VERDICTS, verdictOf, Within } from "./within.js";

/** @param {{ figures: import("../api/client.js").Schema<"FitFigures"> | undefined }} props */
export function FigureTiles({ figures }) {
  const rows = figureRows(figures);
  if (rows.length === 0) return null;
  return html`<ul class="figure-tiles" aria-label=${t.figuresOfFit}>
    ${rows.map(({ name, symbol, figure: { value, std_error, within, conformity } }) => {
      const kind = conformity ? VERDICTS[verdictOf(conformity).key].kind : within === false ? "bad" : "";
      return html`<li key=${name} class=${`figure-tile ${kind}`}>
        <span class="tile-name">${h(GearSymbol, { name: symbol })} <span>${t[name]}</span></span>
        <span class="tile-value"><b translate="no">${fmt.value.deviation(value, "µm", std_error)}</b>${" "}
          <span translate="no">µm</span> ${h(Within, { within, conformity })}</span>
        <span class="tile-limits">${conformity ? html`<span translate="no">${limitText(conformity.limits_um)}</span>` : t.noLimits}</span>
      </li>`;
    })}
  </ul>`;
}
