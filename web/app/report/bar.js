// The contents of a report: iterations, parts, language. The address has them; the bar itself is
// not printed.

import { Checkbox, SelectField } from "../components/form.js";
import { t as common } from "../i18n/common.js";
import { t } from "../i18n/report.js";
import { query, setQuery } from "../navigation.js";
import { h, html } from "../../vendor/ui.js";
import { iterationsOf, PARTS, partsOf, written } from "./parts.js";

/**
 * @param {{ there: readonly number[], numbers: readonly number[], printable: boolean }} props `there`: all iterations;
 *   `numbers`: the selected ones; `printable`: the paper is there
 */
export function Bar({ there, numbers, printable }) {
  const parts = partsOf(query.value.get("parts"));
  const byDefault = iterationsOf(null, there);
  const turn = (/** @type {number} */ number, /** @type {boolean} */ on) => {
    const next = there.filter((one) => (one === number ? on : numbers.includes(one)));
    if (next.length > 0) setQuery({ iterations: written(next, byDefault) });
  };
  const turnPart = (/** @type {string} */ part, /** @type {boolean} */ on) => {
    const next = PARTS.filter((one) => (one === part ? on : parts.includes(one)));
    if (next.length > 0) setQuery({ parts: written(next, PARTS) });
  };
  return html`<section class="panel report-bar" aria-label=${t.options}>
    <fieldset><legend>${t.iterations}</legend><div class="report-choices">
      ${there.map((number) => h(Checkbox, { key: number, label: common.iteration(number), checked: numbers.includes(number), onChange: (on) => turn(number, on) }))}
    </div></fieldset>
    <fieldset><legend>${t.parts}</legend><div class="report-choices">
      ${PARTS.map((part) => h(Checkbox, { key: part, label: t[part], checked: parts.includes(part), onChange: (on) => turnPart(part, on) }))}
    </div></fieldset>
    <div class="report-print">
      ${h(SelectField, {
        label: t.language,
        required: true,
        value: query.value.get("lang") ?? "",
        onChange: (value) => setQuery({ lang: value }),
        options: [
          { value: "", label: t.asDashboard },
          { value: "en", label: t.english },
          { value: "de", label: t.german },
        ],
      })}
      <button type="button" class="button primary" disabled=${!printable} onClick=${() => print()}>${t.print}</button>
      <p class="hint">${t.printHint}</p>
    </div>
  </section>`;
}
