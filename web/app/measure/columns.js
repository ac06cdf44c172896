// The interpretation of a table: its columns with meanings and units that can be changed, and the
// result in words.

import { SelectField } from "../components/form.js";
import { WarningList } from "../components/warnings.js";
import de from "../i18n/de/table.js";
import en from "../i18n/en/table.js";
import { fmt, texts } from "../i18n/i18n.js";
import { UNITS_OF, mappingOf, withColumn } from "../lib/nodes_table.js";
import { h, html } from "../../vendor/ui.js";

const t = texts({ en, de });

/** @typedef {import("../lib/nodes_table.js").Proposal} Proposal */
/** @typedef {import("../lib/nodes_table.js").Mapping} Mapping */
/** @typedef {keyof typeof UNITS_OF} Meaning */

/** Signs of units; words for those that have none. @param {string} unit */
const signOf = (unit) =>
  /** @type {Record<string, string>} */ ({ um: "µm", deg: "°", arcmin: "′", in: t.inches })[unit] ?? unit;

/**
 * @param {{ proposal: Proposal, name: string, onMapping: (mapping: Mapping) => void, disabled: boolean }} props
 *   `name`: of the file
 */
export function Columns({ proposal, name, onMapping, disabled }) {
  const mapping = mappingOf(proposal);
  const label = (/** @type {number} */ k) =>
    proposal.matrix ? t[/** @type {"part_0"} */ (`part_${k}`)] : t.column(k + 1);
  return html`<fieldset class="table-columns" disabled=${disabled}>
    <legend>${t.columns}</legend>
    <p class="quiet">${written(proposal)}</p>
    ${proposal.proposed_from === "kept" && html`<p class="hint" data-remembered>${t.remembered}</p>`}
    <div class="table-column-list">
      ${proposal.columns.map((column, k) => {
        const units = /** @type {readonly import("../lib/nodes_table.js").Unit[]} */ (UNITS_OF[column.meaning]);
        return html`<div key=${k} class="fields">
          ${h(SelectField, {
            label: html`${label(k)}${column.name ? html` <span translate="no">${column.name}</span>` : ""}`,
            required: true,
            value: column.meaning,
            options: Object.keys(UNITS_OF).map((meaning) => ({
              value: meaning,
              label: t[/** @type {Meaning} */ (meaning)],
            })),
            onChange: (value) => onMapping(withColumn(mapping, k, { meaning: /** @type {Meaning} */ (value) })),
          })}
          ${
            units.length > 0 &&
            h(SelectField, {
              label: html`${t.unit}<span class="visually-hidden"> ${t.unitOf(column.name || label(k))}</span>`,
              required: true,
              value: column.unit ?? units[0] ?? "",
              options: units.map((unit) => ({ value: unit, label: signOf(unit), verbatim: unit !== "in" })),
              onChange: (value) =>
                onMapping(
                  withColumn(mapping, k, { unit: /** @type {import("../lib/nodes_table.js").Unit} */ (value) }),
                ),
            })
          }
        </div>`;
      })}
    </div>
    <p class="note" data-preview="table" aria-live="polite">${inWords(proposal) ?? t.nothing(name)}</p>
    ${proposal.warnings.length > 0 && h(WarningList, { warnings: proposal.warnings })}
  </fieldset>`;
}

/** The format of the table. @param {Proposal} proposal */
function written({ separator, decimal, header, matrix }) {
  const names = { ",": t.commas, ";": t.semicolons, tab: t.tab, spaces: t.spaces };
  const decimals = decimal === "," ? t.decimalCommas : t.decimalPoints;
  return t.written(names[separator], decimals, matrix ? t.asMatrix : header ? t.withHeader : t.withoutHeader);
}

/** The meaning of the numbers: "Greatest deviation 20.8 µm, roll length 5.9–11.4 mm." @param {Proposal} proposal */
export function inWords({ preview, layout }) {
  if (!layout) return undefined;
  const parts = preview.ranges
    .filter(({ meaning }) =>
      ["roll_length", "diameter", "roll_angle", "face_width", "x", "y", "z", "u", "v"].includes(meaning),
    )
    .map(({ meaning, unit, min, max }) =>
      [t[meaning], `${fmt.value.three(min)}–${fmt.value.three(max)}`, unit ? signOf(unit) : ""]
        .filter(Boolean)
        .join(" "),
    );
  const greatest = preview.greatest_deviation_um;
  if (greatest !== undefined) parts.unshift(t.greatest(fmt.value.three(greatest)));
  const text = parts.join(", ");
  return `${text.charAt(0).toUpperCase()}${text.slice(1)}.`;
}
