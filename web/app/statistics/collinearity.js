// Dependencies between columns: VIF, variance proportions, correlation.

import { table } from "../components/table.js";
import de from "../i18n/de/statistics.js";
import en from "../i18n/en/statistics.js";
import { fmt, texts } from "../i18n/i18n.js";
import { termSign } from "../lib/terms.js";
import { html } from "../../vendor/ui.js";

/** @typedef {import("../api/client.js").Schema<"FitResult">} FitResult */

const t = texts({ en, de });

/** @param {{ result: FitResult }} props */
export function Collinearity({ result: { collinearity, spectrum } }) {
  const terms = collinearity.columns.map(({ term }) => term);
  return html`<section class="panel half">
      <h2>${t.vif}</h2><p class="quiet">${t.vifText}</p>
      ${table({
        caption: t.vif,
        hideCaption: true,
        columns: [
          {
            key: "term",
            header: t.term,
            rowHeader: true,
            cell: ({ term }) => html`<span class="term" translate="no">${termSign(term)}</span>`,
            csv: ({ term }) => term,
          },
          {
            key: "vif",
            header: t.vifShort,
            numeric: true,
            cell: ({ vif }) => fmt.value.three(vif),
            csv: ({ vif }) => vif,
          },
        ],
        rows: collinearity.columns,
        rowKey: ({ term }) => term,
        csvName: "vif",
      })}
    </section>
    ${
      collinearity.variance_proportions &&
      matrix(
        t.proportions,
        t.proportionsText,
        terms,
        collinearity.variance_proportions,
        spectrum.eigenvalues.map((value) => fmt.value.three(value)),
        "variance-proportions",
      )
    }
    ${collinearity.correlation && matrix(t.correlation, t.correlationText, terms, collinearity.correlation, terms, "correlation")}`;
}

/**
 * @param {string} name @param {string} text @param {readonly string[]} terms @param {readonly (readonly number[])[]} values
 * @param {readonly string[]} heads @param {string} csvName
 */
function matrix(name, text, terms, values, heads, csvName) {
  const rows = values.map((row, i) => ({ term: terms[i] ?? String(i + 1), row }));
  return html`<section class="panel wide">
    <h2>${name}</h2><p class="quiet">${text}</p>
    ${table({
      caption: name,
      hideCaption: true,
      columns: [
        {
          key: "term",
          header: t.term,
          rowHeader: true,
          cell: ({ term }) => html`<span class="term" translate="no">${termSign(term)}</span>`,
          csv: ({ term }) => term,
        },
        ...heads.map((head, i) => ({
          key: String(i),
          header: t.data(termSign(head)),
          numeric: true,
          cell: (/** @type {{ row: readonly number[] }} */ { row }) => {
            const value = row[i] ?? Number.NaN;
            const strong =
              Math.abs(value) >= (csvName === "correlation" ? 0.9 : 0.5) &&
              !(csvName === "correlation" && terms[i] === heads[i] && value === 1);
            return strong ? html`<strong>${fmt.value.fixed(value, 2)}</strong>` : fmt.value.fixed(value, 2);
          },
          csv: (/** @type {{ row: readonly number[] }} */ { row }) => row[i],
        })),
      ],
      rows,
      rowKey: ({ term }) => term,
      csvName,
    })}
  </section>`;
}
