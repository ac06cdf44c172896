// What every criterion would choose, side by side.

import { Criterion } from "../components/criterion.js";
import { table } from "../components/table.js";
import de from "../i18n/de/lambda.js";
import en from "../i18n/en/lambda.js";
import { fmt, texts } from "../i18n/i18n.js";
import { h, html } from "../../vendor/ui.js";

/** @typedef {import("../api/client.js").Schema<"Choice">} Choice */

const t = texts({ en, de });

/**
 * @param {{
 *   choices: readonly Choice[], symbol: string, unit: string | undefined, standingBy: string | undefined,
 *   shownBy: string | undefined, onShow: (criterion: string) => void,
 * }} props
 */
export function Choices({ choices, symbol, unit, standingBy, shownBy, onShow }) {
  /** @type {readonly import("../components/table.js").Column<Choice>[]} */
  const columns = [
    {
      key: "criterion",
      header: t.criterion,
      rowHeader: true,
      cell: ({ criterion }) => h(Criterion, { name: criterion }),
      csv: ({ criterion }) => criterion,
    },
    {
      key: "lambda",
      header: t.symbol(symbol),
      numeric: true,
      cell: (one) => fmt.value.three(one.lambda_star),
      csv: (one) => one.lambda_star,
    },
    {
      key: "mse",
      header: t.predictedMse,
      numeric: true,
      cell: (one) => fmt.value.three(one.predicted_mse),
      csv: (one) => one.predicted_mse,
    },
    {
      key: "condition",
      header: t.condition,
      numeric: true,
      cell: (one) => fmt.value.condition(one.condition),
      csv: (one) => one.condition,
    },
    {
      key: "rms",
      header: t.rms,
      unit,
      numeric: true,
      cell: (one) => fmt.value.three(one.rms),
      csv: (one) => one.rms,
    },
    {
      key: "bias",
      header: t.biasNorm,
      numeric: true,
      cell: (one) => fmt.value.three(one.bias_norm),
      csv: (one) => one.bias_norm,
    },
    {
      key: "show",
      header: t.shown,
      cell: ({ criterion }) =>
        html`<button type="button" class="button small" aria-pressed=${shownBy === criterion ? "true" : "false"}
          aria-label=${t.showChoice(criterion)} onClick=${() => onShow(criterion)}>${t.show}</button>`,
    },
  ];
  return html`<section class="panel">
    <h2>${t.choices}</h2>
    ${table({
      caption: t.choices,
      hideCaption: true,
      columns,
      rows: choices,
      rowKey: ({ criterion }) => criterion,
      rowClass: ({ criterion }) => (criterion === standingBy ? "standing" : ""),
      csvName: "choices",
      stacked: true,
    })}
  </section>`;
}
