// Tables as CSV (RFC 4180): decimal points, full digits, units in the header.

/**
 * @template Row
 * @typedef {object} CsvColumn
 * @property {string} header
 * @property {string} [unit]
 * @property {(row: Row) => string | number | boolean | null | undefined} value
 */

/**
 * @template Row
 * @param {readonly CsvColumn<Row>[]} columns
 * @param {readonly Row[]} rows
 */
export function csv(columns, rows) {
  const head = columns.map(({ header, unit }) => cell(unit ? `${header} [${unit}]` : header));
  const body = rows.map((row) => columns.map((column) => cell(column.value(row))).join(","));
  return [head.join(","), ...body, ""].join("\r\n");
}

/** @param {string | number | boolean | null | undefined} value */
function cell(value) {
  if (value === null || value === undefined) return "";
  if (typeof value === "number") return Number.isFinite(value) ? String(value) : "";
  // places where a word may be parted are no part of it
  const text = String(value).replaceAll("\u00ad", "");
  // a spreadsheet would compute what begins so
  const safe = /^[=+\-@\t\r]/.test(text) ? `'${text}` : text;
  return /[",\r\n]/.test(safe) ? `"${safe.replaceAll('"', '""')}"` : safe;
}

/** Hands a text to the browser as a file. @param {string} name @param {string | Blob} content @param {string} [type] */
export function download(name, content, type = "text/csv;charset=utf-8") {
  const blob = typeof content === "string" ? new Blob([content], { type }) : content;
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name.replaceAll(/[\\/:*?"<>|\p{Cc}]/gu, "_");
  link.click();
  // the download has begun with the click
  URL.revokeObjectURL(link.href);
}
