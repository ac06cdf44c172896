// Tables: with a caption, units in their heads, and as CSV.

import { csv, download } from "../lib/csv.js";
import { t } from "../i18n/common.js";
import { fmt } from "../i18n/i18n.js";
import { ABSENT } from "../lib/format.js";
import { h, html } from "../../vendor/ui.js";

/** @typedef {import("../../vendor/ui.js").ComponentChildren} Children */
/**
 * @template Row
 * @typedef {object} Column
 * @property {string} key
 * @property {string} header
 * @property {Children} [head] the header as shown on the page
 * @property {string | undefined} [unit] written behind the header
 * @property {boolean} [numeric] right-aligned, digits below digits
 * @property {boolean} [rowHeader] names the row
 * @property {boolean} [minor] not on tablets, since the columns do not fit
 * @property {boolean} [screen] not in the report
 * @property {((row: Row) => Children) | undefined} [cell] without it the column is only in the file
 * @property {import("../lib/csv.js").CsvColumn<Row>["value"] | undefined} [csv] its value in full precision; without it the column is omitted from the file
 * @property {"ascending" | "descending" | undefined} [sorted]
 * @property {(() => void) | undefined} [onSort]
 */

/**
 * @template Row
 * @param {{
 *   caption: string,
 *   hideCaption?: boolean,
 *   columns: readonly Column<Row>[],
 *   rows: readonly Row[],
 *   fileRows?: () => readonly Row[],
 *   rowKey: (row: Row) => string | number,
 *   rowClass?: (row: Row) => string,
 *   csvName?: string | undefined,
 *   stacked?: boolean,
 *   tools?: Children,
 *   note?: Children,
 * }} props `csvName`: offers the table as a file of this name, `fileRows` instead of the rows; `stacked`: on narrow screens a card for each row;
 *   `note`: a sentence about the table, below it
 */
export function table({
  caption,
  hideCaption = false,
  columns,
  rows,
  fileRows = () => rows,
  rowKey,
  rowClass,
  csvName,
  stacked = false,
  tools,
  note,
}) {
  const shown = columns.filter(({ cell }) => cell);
  const save = () => {
    const values = columns.flatMap(({ header, unit, csv: value }) =>
      value ? [{ header, value, ...(unit ? { unit } : {}) }] : [],
    );
    download(`${csvName}.csv`, csv(values, fileRows(), fmt.value.locale));
  };
  const bar =
    csvName || tools || note
      ? html`<div class="table-tools">
          ${note && html`<p class="table-note">${note}</p>`} ${tools} ${csvName && html`<button type="button" class="button small" onClick=${save}>${t.csv}</button>`}
        </div>`
      : null;
  // roles are repeated, since a stacked table is laid out as blocks, which drop them
  const body = html`<div class="table-scroll" role="region" tabindex="0" aria-label=${`${caption} (${t.moreBelow})`}>
    <table role="table" class=${stacked ? "stacked" : ""}>
      <caption class=${hideCaption ? "visually-hidden" : ""}>${caption}</caption>
      <thead role="rowgroup">
        <tr role="row">
          ${shown.map((column) => h(Head, { key: column.key, column: /** @type {Column<never>} */ (/** @type {unknown} */ (column)) }))}
        </tr>
      </thead>
      <tbody role="rowgroup">
        ${rows.map(
          (row) => html`<tr role="row" key=${rowKey(row)} class=${rowClass?.(row) ?? ""}>
            ${shown.map((column) => cellOf(column, row))}
          </tr>`,
        )}
      </tbody>
    </table>
  </div>`;
  return html`<div class="table-block">${body}${bar}</div>`;
}

/** @param {{ column: Column<never> }} props */
function Head({ column: { header, head, unit, numeric, minor, screen, sorted, onSort } }) {
  const text = html`<span>${head ?? header}${unit && html` <span class="unit" translate="no">${unit}</span>`}</span>`;
  return html`<th role="columnheader" scope="col" class=${[numeric && "numeric", minor && "minor", screen && "screen"].filter(Boolean).join(" ")} aria-sort=${sorted}>
    ${onSort ? html`<button type="button" class="sort" onClick=${onSort}>${text}</button>` : text}
  </th>`;
}

/** @template Row @param {Column<Row>} column @param {Row} row */
function cellOf({ key, header, head, numeric, minor, screen, rowHeader, cell }, row) {
  const value = cell?.(row);
  const content = html`<span class="cell-label" aria-hidden="true">${head ?? header}</span><span class="cell">${value}</span>`;
  const absent = value === ABSENT || value === "";
  const name = [numeric && "numeric", minor && "minor", screen && "screen", absent && "absent"]
    .filter(Boolean)
    .join(" ");
  if (rowHeader) return html`<th role="rowheader" scope="row" key=${key} class=${name}>${content}</th>`;
  return html`<td role="cell" key=${key} class=${name}>${content}</td>`;
}
