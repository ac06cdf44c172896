// The button that shows a graphic outside of `charts/` as a table.

import { t } from "../i18n/common.js";
import { h, html, useState } from "../../vendor/ui.js";

/**
 * Returns the state of the table, and its button.
 * @param {string} name of the graphic, since a page may have several
 */
export function useAsTable(name) {
  const [asTable, setAsTable] = useState(false);
  return { asTable, button: h(TableButton, { name, asTable, onToggle: () => setAsTable(!asTable) }) };
}

/** @param {{ name: string, asTable: boolean, onToggle: () => void }} props */
function TableButton({ name, asTable, onToggle }) {
  const text = asTable ? t.asChart : t.asTable;
  return html`<button type="button" class="button small" aria-pressed=${asTable} aria-label=${`${text}: ${name}`} onClick=${onToggle}>${text}</button>`;
}
