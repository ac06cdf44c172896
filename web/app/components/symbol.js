// Symbols of gear metrology, such as f_Hα, with their index below.

import { html } from "../../vendor/ui.js";

/** @param {{ name: string }} props the part behind `_` is the index */
export function GearSymbol({ name }) {
  const [letter, index] = name.split("_");
  return html`<span class="gear-symbol" translate="no"><i>${letter}</i>${index && html`<sub>${index}</sub>`}</span>`;
}
