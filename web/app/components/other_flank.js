// The other flank, as changed by the settings common to both flanks.

import { t } from "../i18n/correction.js";
import { h, html } from "../../vendor/ui.js";
import { Figures, ofFlank } from "./correction_result.js";

/** @typedef {import("../api/client.js").Schema<"Correction">} Correction */

/** @param {{ kept: Correction, other: import("../api/client.js").Schema<"OtherFlank"> }} props */
export function OtherFlank({ kept, other: { flank, iteration, figures, not_predicted: refused } }) {
  const title = t[`other_${flank}`];
  return html`<section class="panel" aria-labelledby="other-flank">
    <h2 id="other-flank">${title}</h2>
    <p class="quiet">${iteration == null ? t.otherNotMeasured : t.otherAbout(iteration)}</p>
    ${figures && h(Figures, { kept: ofFlank(kept, flank, figures), of: title })}
    ${refused && iteration != null && html`<p>${t.otherNotPredicted} <span lang="en">${refused}</span></p>`}
  </section>`;
}
