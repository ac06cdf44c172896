// Eigenvalues before and after regularisation; each direction with its weights.

import { Dependency } from "../components/dependency.js";
import { Chart } from "../charts/chart.js";
import { Dots, Rule } from "../charts/marks.js";
import { table } from "../components/table.js";
import de from "../i18n/de/statistics.js";
import en from "../i18n/en/statistics.js";
import { fmt, texts } from "../i18n/i18n.js";
import { query, setQuery } from "../navigation.js";
import { raisedIn } from "../lib/spectrum.js";
import { termSign } from "../lib/terms.js";
import { h, html } from "../../vendor/ui.js";

/** @typedef {import("../api/client.js").Schema<"IterationFit">} IterationFit */

const t = texts({ en, de });

/** @param {{ fit: IterationFit }} props */
export function Spectrum({ fit: { result, spec } }) {
  const before = result.spectrum.eigenvalues;
  const after = result.spectrum.regularized.eigenvalues;
  const rows = before.map((value, i) => ({ i, before: value, after: after?.[i] }));
  const positive = [...before, ...(after ?? [])].filter((value) => value > 0);
  const regularization = /** @type {{ condition_limit?: number }} */ (spec.regularization ?? {});
  const limit = regularization.condition_limit;
  const greatest = before.at(-1) ?? 0;
  const bound = limit && greatest > 0 ? greatest / limit : undefined;
  const picked = Number(query.value.get("direction") ?? Number.NaN);
  const raised = raisedIn(before, after);
  return html`<section class="panel">
    ${h(Chart, {
      name: t.spectrum,
      level: 2,
      summary: t.spectrumSummary(
        fmt.value.condition(result.spectrum.condition),
        fmt.value.condition(result.spectrum.regularized.condition),
        fmt.value.count(raised),
        fmt.value.count(before.length),
      ),
      x: { label: t.direction, domain: [0.5, before.length + 0.5], ticks: Math.min(10, before.length) },
      y: {
        label: t.eigenvalue,
        scale: "log",
        domain: [Math.min(...positive, bound ?? greatest) / 2, Math.max(...positive) * 2],
      },
      height: 340,
      probes: rows
        .filter((row) => row.before > 0)
        .map((row) => ({
          x: row.i + 1,
          y: row.before,
          text: `${row.i + 1}: ${fmt.value.three(row.before)} → ${fmt.value.three(row.after)}`,
        })),
      onPick: ({ x }) => setQuery({ direction: x }),
      data: {
        columns: [
          {
            key: "i",
            header: t.direction,
            numeric: true,
            rowHeader: true,
            cell: ({ i }) => i + 1,
            csv: ({ i }) => i + 1,
          },
          {
            key: "before",
            header: t.before,
            numeric: true,
            cell: (row) => fmt.value.three(row.before),
            csv: (row) => row.before,
          },
          {
            key: "after",
            header: t.after,
            numeric: true,
            cell: (row) => fmt.value.three(row.after),
            csv: (row) => row.after,
          },
        ],
        rows,
        rowKey: ({ i }) => i,
        csvName: "eigenvalues",
      },
      children: (plot) => html`
        ${bound !== undefined && h(Rule, { plot, y: bound, label: t.conditionLimit(fmt.value.count(limit)), kind: "limit" })}
        ${raised > 0 && raised < before.length && h(Rule, { plot, x: raised + 0.5, label: t.regularisedTo(fmt.value.count(raised)) })}
        ${after && h(Dots, { plot, points: rows.map((row) => ({ x: row.i + 1, y: row.after })), series: "vermilion", sign: "square" })}
        ${h(Dots, { plot, points: rows.map((row) => ({ x: row.i + 1, y: row.before > 0 ? row.before : null })) })}`,
    })}
    <ul class="legend-list quiet">
      <li><svg width="14" height="12" aria-hidden="true" class="chart mark-dots series-blue"><path d="M3 6a4 4 0 1 0 8 0a4 4 0 1 0 -8 0" /></svg>${t.before}</li>
      <li><svg width="14" height="12" aria-hidden="true" class="chart mark-dots series-vermilion"><path d="M3.5 2.5h7v7h-7z" /></svg>${t.after}</li>
    </ul>
    ${picked >= 1 && picked <= before.length ? h(Direction, { result, number: picked }) : html`<p class="quiet">${t.pickDirection}</p>`}
  </section>`;
}

/** @param {{ result: IterationFit["result"], number: number }} props */
function Direction({ result, number }) {
  const eigenvalue = result.spectrum.eigenvalues[number - 1];
  const found = result.collinearity.near_dependencies.find((one) => one.eigenvalue === eigenvalue);
  const rows = result.coefficients.map(({ term }, i) => ({ term, weight: found?.weights?.[i] }));
  return html`<section class="direction" aria-live="polite">
    <div class="direction-words">
      <h3>${t.directionTitle(number, fmt.value.three(eigenvalue))}</h3>
      ${found ? html`<p>${h(Dependency, { of: found })}</p>` : html`<p class="quiet">${t.noDependency}</p>`}
    </div>
    ${
      found?.weights &&
      table({
        caption: t.weights,
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
            key: "weight",
            header: t.weight,
            numeric: true,
            cell: ({ weight }) => fmt.value.fixed(weight, 3),
            csv: ({ weight }) => weight,
          },
        ],
        rows,
        rowKey: ({ term }) => term,
        csvName: `direction-${number}`,
      })
    }
  </section>`;
}
