// Columns common to tables of fits and of coefficients.

import { fmt } from "../i18n/i18n.js";
import { h, html } from "../../vendor/ui.js";
import { Criterion, criterionLabel } from "./criterion.js";
import { termSign } from "../lib/terms.js";
import { WithError } from "./figure.js";

/** @typedef {number | null | undefined} Maybe */
/**
 * @template Row
 * @typedef {import("./table.js").Column<Row>} Column
 */

/** The criterion of a choice, as the head of its row. @template {{ criterion?: string | null }} Row @param {string} header @returns {Column<Row>} */
export const criterionColumn = (header) => ({
  key: "criterion",
  header,
  rowHeader: true,
  cell: ({ criterion }) => h(Criterion, { name: criterion }),
  csv: ({ criterion }) => criterionLabel(criterion) ?? criterion,
});

/**
 * A number: in the table as `write` formats it, in the file in full.
 * @template Row
 * @param {string} key @param {string} header @param {(row: Row) => Maybe} of
 * @param {{ write?: ((value: Maybe) => string) | undefined, unit?: string | undefined }} [more] `write`: by default three digits
 * @returns {Column<Row>}
 */
export const numberColumn = (key, header, of, { write = fmt.value.three, unit } = {}) => ({
  key,
  header,
  unit,
  numeric: true,
  cell: (row) => write(of(row)),
  csv: of,
});

/** The term of a coefficient, as the head of its row. @template {{ term?: string | null }} Row @param {string} header @returns {Column<Row>} */
export const termColumn = (header) => ({
  key: "term",
  header,
  rowHeader: true,
  cell: ({ term }) => html`<span class="term" translate="no">${termSign(term)}</span>`,
  csv: ({ term }) => term,
});

/**
 * An estimate to the second digit of its standard error.
 * @template Row
 * @param {string} key @param {string} header @param {(row: Row) => { value?: Maybe, std_error?: Maybe } | undefined} of
 * @param {(row: Row) => string | undefined} [unit]
 * @returns {Column<Row>}
 */
export const estimateColumn = (key, header, of, unit) => ({
  key,
  header,
  numeric: true,
  cell: (row) => h(WithError, { value: of(row)?.value, error: of(row)?.std_error, unit: unit?.(row) }),
  csv: (row) => of(row)?.value,
});
