// Two fits of a job beside each other, their differences in standard errors.

import { SelectField } from "../components/form.js";
import { WithError } from "../components/figure.js";
import { table } from "../components/table.js";
import de from "../i18n/de/trace.js";
import en from "../i18n/en/trace.js";
import { fmt, texts } from "../i18n/i18n.js";
import { query, setQuery } from "../navigation.js";
import { h, html } from "../../vendor/ui.js";
import { compared } from "./entries.js";

/** @typedef {import("../api/job.js").TracedIteration} TracedIteration */
/** @typedef {ReturnType<typeof compared>[number]} Row */

const t = texts({ en, de });

/** @param {{ iterations: readonly TracedIteration[] }} props */
export function Compare({ iterations }) {
  const all = iterations.flatMap((iteration) => iteration.fits.map((fit, i) => ({ iteration, fit, i })));
  if (all.length < 2)
    return html`<section class="panel"><h2>${t.compare}</h2><p class="quiet">${t.compareNeedsTwo}</p></section>`;
  const standing = all.filter(({ fit }) => fit.chosen);
  const find = (/** @type {string} */ name) => all.find(({ fit }) => fit.id === query.value.get(name));
  const a = find("a") ?? standing[0] ?? all[0];
  const b = find("b") ?? standing.findLast((one) => one !== a) ?? all.findLast((one) => one !== a);
  if (!a || !b) return null;
  const options = all.map(({ iteration, fit, i }) => ({
    value: fit.id,
    label: t.fitOption(iteration.number, i + 1, fit.criterion ?? t.unregularized, fmt.value.three(fit.lambda_star)),
  }));
  const same = a.iteration === b.iteration;
  const rows = compared(a.fit, b.fit, same);
  /** @type {readonly import("../components/table.js").Column<Row>[]} */
  const columns = [
    {
      key: "term",
      header: t.term,
      rowHeader: true,
      cell: ({ term }) => html`<code translate="no">${term}</code>`,
      csv: ({ term }) => term,
    },
    {
      key: "a",
      header: t.first,
      numeric: true,
      cell: (row) => h(WithError, { value: row.a.value, error: row.a.std_error }),
      csv: (row) => row.a.value,
    },
    {
      key: "b",
      header: t.second,
      numeric: true,
      cell: (row) => h(WithError, { value: row.b.value, error: row.b.std_error }),
      csv: (row) => row.b.value,
    },
    {
      key: "difference",
      header: t.difference,
      numeric: true,
      cell: (row) => fmt.value.three(row.difference),
      csv: (row) => row.difference,
    },
    {
      key: "errors",
      header: t.inErrors,
      numeric: true,
      cell: (row) => fmt.value.fixed(row.inErrors, 1),
      csv: (row) => row.inErrors,
    },
  ];
  return html`<section class="panel trace-compare">
    <h2>${t.compare}</h2>
    <div class="fields">
      ${h(SelectField, { label: t.first, required: true, value: a.fit.id, options, onChange: (value) => setQuery({ a: value }) })}
      ${h(SelectField, { label: t.second, required: true, value: b.fit.id, options, onChange: (value) => setQuery({ b: value }) })}
    </div>
    <p class="quiet">${same ? t.sameNodes : t.otherNodes}</p>
    ${
      rows.length === 0
        ? html`<p class="note">${t.noCommonTerm}</p>`
        : table({
            caption: t.compare,
            hideCaption: true,
            columns,
            rows,
            rowKey: ({ term }) => term,
            csvName: "comparison",
          })
    }
  </section>`;
}
