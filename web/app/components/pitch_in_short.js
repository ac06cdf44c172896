// The pitches and the run-out of an iteration in short, with a link to all of them.

import { useRecord } from "../api/records.js";
import { t as common } from "../i18n/common.js";
import { fmt } from "../i18n/i18n.js";
import { t } from "../i18n/pitch.js";
import { hrefIf } from "../router.js";
import { h, html } from "../../vendor/ui.js";
import { Facts } from "./figure.js";
import { flankRows, runoutRow } from "./pitch_table.js";
import { loaded } from "./states.js";
import { GearSymbol } from "./symbol.js";
import { Within } from "./within.js";

/** @typedef {import("../api/records.js").RecordSummary} RecordSummary */
/** @typedef {import("../api/records.js").JobRecord} JobRecord */
/** @typedef {import("../api/client.js").Schema<"PitchEvaluation">} PitchEvaluation */

/** Figures that have limits; the others are shown with their charts. */
const SHORT = /** @type {readonly string[]} */ (["f_p", "F_p", "F_r"]);

/** Returns the pitches stored last, if there are any. @param {string} jobId @param {number} number @param {readonly RecordSummary[]} records */
export function usePitch(jobId, number, records) {
  const id = records.findLast(({ kind }) => kind === "pitch")?.id;
  const record = useRecord(jobId, number, id);
  return id === undefined ? undefined : record;
}

/** @param {{ jobId: string, number: number, pitch: NonNullable<ReturnType<typeof usePitch>> }} props */
export function PitchInShort({ jobId, number, pitch }) {
  const to = hrefIf("/jobs/{job_id}/iterations/{number}/evaluation", { job_id: jobId, number });
  return html`<section class="panel" aria-labelledby="pitch">
    <header><h2 id="pitch">${t.title}</h2>${to && html`<a class="button small" href=${to}>${common.evaluation}</a>`}</header>
    ${loaded({
      resource: pitch,
      lines: 3,
      children: (whole) => {
        const { result } = /** @type {JobRecord} */ (whole);
        const { left, right, runout } = /** @type {PitchEvaluation} */ (/** @type {unknown} */ (result));
        const items = [
          ...(left ? [{ name: t.leftFlanks, value: inShort(flankRows(left)) }] : []),
          ...(right ? [{ name: t.rightFlanks, value: inShort(flankRows(right)) }] : []),
          ...(runout ? [{ name: t.runout, value: inShort([runoutRow(runout)]) }] : []),
        ];
        return h(Facts, { items, columns: true });
      },
    })}
  </section>`;
}

/** @param {readonly import("./pitch_table.js").Row[]} rows */
function inShort(rows) {
  const listed = rows.filter(({ symbol }) => SHORT.includes(symbol));
  return html`<span class="pitch-short">${listed.map(
    ({ key, symbol, name, value, within }) => html`<span key=${key} class="figure">
      ${h(GearSymbol, { name: symbol })} <span class="visually-hidden">${name}</span>${" "}
      <span translate="no">${fmt.value.um(value)}\u202fµm</span> ${h(Within, { within })}${" "}
    </span>`,
  )}</span>`;
}
