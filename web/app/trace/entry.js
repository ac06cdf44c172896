// One entry of the story.

import { Criterion } from "../components/criterion.js";
import { FiguresInShort } from "../components/flank_figures.js";
import { Badge } from "../components/figure.js";
import { t as common } from "../i18n/common.js";
import de from "../i18n/de/trace.js";
import en from "../i18n/en/trace.js";
import { fmt, texts } from "../i18n/i18n.js";
import { hrefIf } from "../router.js";
import { unitSign } from "../lib/units.js";
import { h, html } from "../../vendor/ui.js";

/** @typedef {import("./entries.js").Entry} Entry */

const t = texts({ en, de });

/** @param {{ entry: Entry, jobId: string, unit: string | undefined }} props */
export function EntryText({ entry, jobId, unit }) {
  const by = doneBy(entry);
  const time = html`<time class="quiet" datetime=${entry.time} translate="no">${fmt.value.time(entry.time)}</time>
    ${by && html`<span class="quiet">${t.by} <span translate="no">${by}</span></span>`}`;
  const head = (/** @type {string} */ name, /** @type {unknown} */ more = null) =>
    html`<p class="trace-head"><strong>${name}</strong>${more}<span class="trace-of quiet">${common.iteration(entry.iteration)}</span>${time}</p>`;
  if (entry.kind === "measured") {
    return html`${head(t.measuredEntry)}${entry.correctionOf !== undefined && html`<p>${t.afterCorrection(entry.correctionOf)}</p>`}`;
  }
  if (entry.kind === "fit") {
    const to = hrefIf(
      "/jobs/{job_id}/iterations/{number}/lambda",
      { job_id: jobId, number: entry.iteration },
      { fit: entry.fit.id },
    );
    return html`${head(t.fitEntry, entry.fit.chosen && h(Badge, { kind: "good", children: t.chosen }))}
      <p>${to ? html`<a href=${to}>${h(Criterion, { name: entry.fit.criterion })}</a>` : h(Criterion, { name: entry.fit.criterion })}</p>
      ${h(Figures, { fit: entry.fit, unit })}${h(FiguresInShort, { figures: entry.fit.figures })}${reason(entry.fit.reason)}`;
  }
  if (entry.kind === "choice") {
    return html`${head(entry.until ? t.wasChosenEntry : t.chosenEntry)}
      <p>${entry.fit ? html`${h(Criterion, { name: entry.fit.criterion })} <span translate="no">λ* ${fmt.value.three(entry.fit.lambda_star)}</span>` : t.earlierFit}</p>
      ${entry.until && html`<p class="quiet">${t.until} <time datetime=${entry.until} translate="no">${fmt.value.time(entry.until)}</time></p>`}
      ${reason(entry.reason)}`;
  }
  if (entry.kind === "record" && entry.record.measurand) {
    const { before, ...after } = entry.record.measurand;
    return html`${head(t.measurand)}<p>${saidOf(before)} → ${saidOf(after)}</p>`;
  }
  if (entry.kind === "record") {
    return html`${head(t[entry.record.kind])}<p class="quiet">${t.method} ${methodOf(entry.record.method)}</p>`;
  }
  const known = entry.decision === "accepted" ? "good" : entry.decision === "rejected" ? "bad" : "warn";
  const word =
    { accepted: common.accepted, rejected: common.rejected, remachine: common.remachine }[entry.decision] ??
    entry.decision;
  return html`${head(t.decisionEntry, h(Badge, { kind: known, children: word }))}${entry.concession && html`<p>${t.concession}</p>`}${reason(entry.reason)}`;
}

/** The page's word for a method, if there is one. @param {string} method */
function methodOf(method) {
  if (method === "iso_1328_1") return html`<span translate="no">ISO 1328-1</span>`;
  const words = { form_grinding: t.form_grinding, generating_grinding: t.generating_grinding, matrix: t.matrix };
  return words[/** @type {"matrix"} */ (method)] ?? html`<code translate="no">${method}</code>`;
}

/** The actor, if it is known. @param {Entry} entry */
function doneBy(entry) {
  if (entry.kind === "measured") return undefined;
  if (entry.kind === "fit") return entry.fit.by;
  return entry.kind === "record" ? entry.record.by : entry.by;
}

/** The known measurand of the nodes. @param {import("../api/client.js").Schema<"KnownMeasurand">} known */
function saidOf({ flank, tooth, axes, accept_units: accepted }) {
  const units = ["u", "v", "z"].flatMap((name) => {
    const axis = axes?.[/** @type {"u"} */ (name)];
    return axis ? [`${name} ${axis.quantity} ${unitSign(axis.unit)}`] : [];
  });
  const parts = [flank && t[flank], tooth && `${t.tooth} ${tooth}`, ...units, accepted && t.unitsAccepted];
  return parts.filter(Boolean).join(", ") || t.nothingSaid;
}

/** @param {string | null | undefined} text */
const reason = (text) => text && html`<blockquote translate="no">${text}</blockquote>`;

/** @param {{ fit: import("./entries.js").TracedFit, unit: string | undefined }} props */
function Figures({ fit, unit }) {
  return html`<dl class="trace-figures">
    <div><dt translate="no">λ*</dt><dd translate="no">${fmt.value.three(fit.lambda_star)}</dd></div>
    <div><dt>${t.condition}</dt><dd translate="no">${fmt.value.condition(fit.regularized_condition ?? fit.condition)}</dd></div>
    <div><dt>${t.rms}</dt><dd translate="no">${fmt.value.three(fit.rms)}${unit && fit.rms != null ? ` ${unit}` : ""}</dd></div>
  </dl>`;
}
