// Tables as CSV (RFC 4180) for spreadsheets of a language, with units in the header: with commas and decimal points, or in
// German with semicolons, decimal commas and a byte order mark.

/** @typedef {string | number | boolean | null | undefined} Value */
/**
 * @template Row
 * @typedef {object} CsvColumn
 * @property {string} header
 * @property {string} [unit]
 * @property {(row: Row) => Value | readonly number[]} value a list: the ends of an interval
 */
/** @typedef {import("./format.js").Locale} Locale */

const WAYS = {
  en: { begin: "", separator: ",", comma: ".", yes: "true", no: "false" },
  de: { begin: "\uFEFF", separator: ";", comma: ",", yes: "ja", no: "nein" },
};

/** Significant digits: more than any instrument resolves, without binary rounding noise. */
const DIGITS = 10;

/**
 * @template Row
 * @param {readonly CsvColumn<Row>[]} columns
 * @param {readonly Row[]} rows
 * @param {Locale} [locale]
 */
export function csv(columns, rows, locale = "en") {
  const { begin, separator } = WAYS[locale];
  const head = columns.map(({ header, unit }) => cell(unit ? `${header} [${unit}]` : header, locale));
  const body = rows.map((row) => columns.map((column) => cell(column.value(row), locale)).join(separator));
  return begin + [head.join(separator), ...body, ""].join("\r\n");
}

/** @param {number} value @param {Locale} locale */
const number = (value, locale) =>
  Number.isFinite(value) ? String(Number(value.toPrecision(DIGITS))).replace(".", WAYS[locale].comma) : "";

/** @param {Value | readonly number[]} value @param {Locale} locale */
function cell(value, locale) {
  if (value === null || value === undefined) return "";
  if (typeof value === "number") return number(value, locale);
  if (typeof value === "boolean") return value ? WAYS[locale].yes : WAYS[locale].no;
  // soft hyphens are not part of the text
  const text = typeof value === "string" ? value.replaceAll("\u00ad", "") : interval(value, locale);
  // a spreadsheet would evaluate such a text as a formula
  const safe = typeof value === "string" && /^[=+\-@\t\r]/.test(text) ? `'${text}` : text;
  return safe.includes(WAYS[locale].separator) || /["\r\n]/.test(safe) ? `"${safe.replaceAll('"', '""')}"` : safe;
}

/** @param {readonly number[]} ends @param {Locale} locale */
const interval = (ends, locale) => ends.map((end) => number(end, locale)).join(" … ");

/** Offers a text as a file to save. @param {string} name @param {string | Blob} content @param {string} [type] */
export function download(name, content, type = "text/csv;charset=utf-8") {
  const blob = typeof content === "string" ? new Blob([content], { type }) : content;
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name.replaceAll(/[\\/:*?"<>|\p{Cc}]/gu, "_");
  link.click();
  // the download has begun with the click
  URL.revokeObjectURL(link.href);
}
