// The choices of all criteria, side by side.

import { may } from "../api/key.js";
import { criterionColumn, numberColumn } from "../components/columns.js";
import { table } from "../components/table.js";
import de from "../i18n/de/lambda.js";
import en from "../i18n/en/lambda.js";
import { fmt, texts } from "../i18n/i18n.js";
import { html } from "../../vendor/ui.js";

/** @typedef {import("../api/client.js").Schema<"Choice">} Choice */

const t = texts({ en, de });

/** The columns of a choice. @param {string} symbol @param {string | undefined} unit @returns {import("../components/table.js").Column<Choice>[]} */
export function choiceColumns(symbol, unit) {
  return [
    criterionColumn(t.criterion),
    numberColumn("lambda", t.symbol(symbol), (one) => one.lambda_star),
    numberColumn("mse", t.predictedMse, (one) => one.predicted_mse),
    numberColumn("condition", t.condition, (one) => one.condition, { write: fmt.value.condition }),
    numberColumn("rms", t.rms, (one) => one.rms, { unit }),
    numberColumn("bias", t.biasNorm, (one) => one.bias_norm),
  ];
}

/**
 * @param {{
 *   choices: readonly Choice[], symbol: string, unit: string | undefined, chosenBy: string | undefined,
 *   shownBy: string | undefined, onShow: (criterion: string) => void,
 * }} props
 */
export function Choices({ choices, symbol, unit, chosenBy, shownBy, onShow }) {
  /** @type {import("../components/table.js").Column<Choice>} */
  const show = {
    key: "show",
    header: t.shown,
    cell: ({ criterion }) =>
      html`<button type="button" class="button small" aria-pressed=${shownBy === criterion ? "true" : "false"}
        aria-label=${t.showChoice(criterion)} onClick=${() => onShow(criterion)}>${t.show}</button>`,
  };
  const columns = [...choiceColumns(symbol, unit), ...(may("compute") ? [show] : [])];
  return html`<section class="panel">
    <h2>${t.choices}</h2>
    ${table({
      caption: t.choices,
      hideCaption: true,
      columns,
      rows: choices,
      rowKey: ({ criterion }) => criterion,
      rowClass: ({ criterion }) => (criterion === chosenBy ? "chosen" : ""),
      csvName: "choices",
      stacked: true,
    })}
  </section>`;
}
