// Two fits of a job side by side, their differences in standard errors.

import { estimateColumn, numberColumn, termColumn } from "../components/columns.js";
import { SelectField } from "../components/form.js";
import { table } from "../components/table.js";
import de from "../i18n/de/trace.js";
import en from "../i18n/en/trace.js";
import { fmt, texts } from "../i18n/i18n.js";
import { unitOf } from "../flank/figures.js";
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
  const chosen = all.filter(({ fit }) => fit.chosen);
  const find = (/** @type {string} */ name) => all.find(({ fit }) => fit.id === query.value.get(name));
  const a = find("a") ?? chosen[0] ?? all[0];
  const b = find("b") ?? chosen.findLast((one) => one !== a) ?? all.findLast((one) => one !== a);
  if (!a || !b) return null;
  const options = all.map(({ iteration, fit, i }) => ({
    value: fit.id,
    label: t.fitOption(iteration.number, i + 1, fit.criterion ?? t.unregularized, fmt.value.three(fit.lambda_star)),
  }));
  const same = a.iteration === b.iteration;
  const rows = compared(a.fit, b.fit, same);
  /** Returns the common unit of both. @param {Row} row */
  const difference = (row) => {
    const [one, other] = [unitOf(row.a, a.iteration.axes), unitOf(row.b, b.iteration.axes)];
    const unit = one === other ? one : undefined;
    return html`<span translate="no">${fmt.value.three(row.difference)}${unit ? `\u202f${unit}` : ""}</span>`;
  };
  /** @type {readonly import("../components/table.js").Column<Row>[]} */
  const columns = [
    termColumn(t.term),
    estimateColumn(
      "a",
      t.first,
      (row) => row.a,
      (row) => unitOf(row.a, a.iteration.axes),
    ),
    estimateColumn(
      "b",
      t.second,
      (row) => row.b,
      (row) => unitOf(row.b, b.iteration.axes),
    ),
    {
      ...numberColumn("difference", t.difference, (/** @type {Row} */ row) => row.difference),
      cell: (row) => difference(row),
    },
    numberColumn("errors", t.inErrors, (row) => row.inErrors, { write: (value) => fmt.value.fixed(value, 1) }),
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
