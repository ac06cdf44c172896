// Suspected gross errors next to the map, and excluding nodes from the chosen fit: each change is a
// stored refit.

import { useAttempt } from "../api/attempt.js";
import { answer, api } from "../api/client.js";
import { may } from "../api/key.js";
import { Failure } from "../components/states.js";
import { notify } from "../components/toast.js";
import de from "../i18n/de/exclude.js";
import en from "../i18n/en/exclude.js";
import { fmt, texts } from "../i18n/i18n.js";
import { excludedBy, excluding, outliersOf, suspectsOf } from "../lib/exclude.js";
import { termSign } from "../lib/terms.js";
import { h, html, useState } from "../../vendor/ui.js";

/** @typedef {import("../api/client.js").Schema<"Iteration">} Iteration */
/** @typedef {import("../api/client.js").Schema<"IterationFit">} IterationFit */
/** @typedef {ReturnType<typeof useExclusion>} Exclusion */

const t = texts({ en, de });

/** Number of columns of a grid; undefined for other nodes. @param {import("../api/client.js").Schema<"Nodes"> | undefined} nodes */
export const columnsOf = (nodes) => (nodes?.type === "grid" ? nodes.v.length : undefined);

/** Names a node. @param {number} index @param {number | undefined} columns */
const placeOf = (index, columns) =>
  columns === undefined ? String(index + 1) : t.cell(Math.floor(index / columns) + 1, (index % columns) + 1);

/**
 * Actions on the chosen fit.
 * @param {{ iteration: Iteration, fit: IterationFit | undefined, columns: number | undefined,
 *   onChosen: (iteration: Iteration, etag: string | undefined) => void }} of
 */
export function useExclusion({ iteration, fit, columns, onChosen }) {
  const [sending, setSending] = useState(false);
  const [error, setError] = useState(/** @type {unknown} */ (undefined));
  const path = { job_id: iteration.job_id, number: iteration.number };
  const attempt = useAttempt(`exclude ${path.job_id} ${path.number}`);
  const excluded = fit ? excludedBy(fit.spec, columns) : [];
  const refit = async (/** @type {readonly number[]} */ out, /** @type {string} */ reason) => {
    if (!fit || sending) return;
    setSending(true);
    setError(undefined);
    try {
      const body = { ...excluding(fit.spec, out, columns), reason };
      const header = attempt.headers(body);
      const { data, etag } = await answer(
        api.POST("/v1/jobs/{job_id}/iterations/{number}/fits", { params: { path, header }, body }),
      );
      attempt.done();
      // the refit created a new version of the iteration
      const params = { path, header: etag ? { "If-Match": etag } : {} };
      const chosen = await answer(
        api.PUT("/v1/jobs/{job_id}/iterations/{number}/chosen-fit", { params, body: { fit_id: data.id, reason } }),
      );
      onChosen(chosen.data, chosen.etag);
      notify(t.done);
    } catch (failed) {
      setError(failed);
    } finally {
      setSending(false);
    }
  };
  const named = (/** @type {readonly number[]} */ nodes) =>
    nodes.map((index) => t.node(placeOf(index, columns))).join("; ");
  return {
    allowed: may("decide") && fit !== undefined,
    columns,
    excluded,
    sending,
    error,
    leaveOut: (/** @type {readonly number[]} */ nodes) => refit([...excluded, ...nodes], t.reasonOut(named(nodes))),
    takeBack: (/** @type {readonly number[]} */ nodes) =>
      refit(
        excluded.filter((index) => !nodes.includes(index)),
        t.reasonBack(named(nodes)),
      ),
  };
}

/** The action for one node. @param {{ exclusion: Exclusion, index: number }} props */
export function NodeAction({ exclusion, index }) {
  if (!exclusion.allowed) return null;
  const out = exclusion.excluded.includes(index);
  return html`<button type="button" class="button small" disabled=${exclusion.sending}
    onClick=${() => (out ? exclusion.takeBack([index]) : exclusion.leaveOut([index]))}>${out ? t.takeBack : t.leaveOut}</button>`;
}

/** @param {{ exclusion: Exclusion, fit: IterationFit, unit: string | undefined }} props */
export function Suspects({ exclusion, fit, unit }) {
  const found = suspectsOf(fit.result.warnings);
  const { columns, excluded } = exclusion;
  if (found.length === 0 && excluded.length === 0) return null;
  const inUnit = (/** @type {number} */ off) => `${fmt.value.deviation(off, unit)}${unit ? ` ${unit}` : ""}`;
  /** @type {readonly { term: string, value: number, without: number, exceeds_interval: boolean }[]} */
  const coefficients = outliersOf(fit.result.warnings)?.["coefficients"] ?? [];
  const moved = coefficients.filter((one) => one.exceeds_interval);
  const said = moved.map((one) =>
    t.insteadOf(termSign(one.term), fmt.value.three(one.without), fmt.value.three(one.value)),
  );
  return html`<section class="panel" aria-labelledby="suspects">
    <h2 id="suspects">${found.length > 0 ? t.suspected : t.excluded}</h2>
    ${
      found.length > 0 &&
      html`<p>${t.about(found.length)}${found.length >= 3 && ` ${t.heavyTails}`}</p>
      <ul class="suspects">${found.map(
        ({ index, off, off_sigmas }) => html`<li key=${index}>
          <svg viewBox="-8 -8 16 16" width="14" height="14" aria-hidden="true"><path class="suspect-mark" d="M-5 -5L5 5M-5 5L5 -5" /></svg>
          <span>${t.node(placeOf(index, columns))} · <span translate="no">${t.off(inUnit(off), fmt.value.significant(Math.abs(off_sigmas), 3))}</span></span>
          ${h(NodeAction, { exclusion, index })}
        </li>`,
      )}</ul>
      <p>${said.length > 0 ? t.moved(said.join(", ")) : t.unmoved}</p>
      <p class="hint">${t.check}</p>
      ${exclusion.allowed && found.length > 1 && html`<div class="actions"><button type="button" class="button small" disabled=${exclusion.sending} onClick=${() => exclusion.leaveOut(found.map(({ index }) => index))}>${t.leaveAllOut}</button></div>`}`
    }
    ${
      excluded.length > 0 &&
      html`${found.length > 0 && html`<h3>${t.excluded}</h3>`}
      <ul class="suspects">${excluded.map(
        (index) => html`<li key=${index}>
          <svg viewBox="-8 -8 16 16" width="14" height="14" aria-hidden="true"><circle class="excluded-mark" r="5" /></svg>
          <span>${t.node(placeOf(index, columns))}</span>
          ${h(NodeAction, { exclusion, index })}
        </li>`,
      )}</ul>`
    }
    ${exclusion.error !== undefined && h(Failure, { error: exclusion.error })}
  </section>`;
}
