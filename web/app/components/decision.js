// The decision on an iteration: accept, machine again or reject, with a reason.

import { answer, api } from "../api/client.js";
import { ApiError } from "../api/problem.js";
import { t as common } from "../i18n/common.js";
import { fmt, texts } from "../i18n/i18n.js";
import { useDraft } from "../lib/draft.js";
import de from "../i18n/de/decision.js";
import en from "../i18n/en/decision.js";
import { Fragment, h, html, useState } from "../../vendor/ui.js";
import { Allowed } from "./allowed.js";
import { Dialog } from "./dialog.js";
import { Badge } from "./figure.js";
import { figureRows } from "./flank_figures.js";
import { TextField } from "./form.js";
import { Failure } from "./states.js";
import { announce, notify } from "./toast.js";

const t = texts({ en, de });

/** @typedef {import("../api/client.js").Schema<"Iteration">} Iteration */
/** @typedef {import("../api/client.js").Schema<"Decision">} DecisionName */

const KINDS = /** @type {const} */ ({ accepted: "good", remachine: "warn", rejected: "bad" });
const ORDER = /** @type {const} */ (["accepted", "remachine", "rejected"]);

/** A decision with its word, sign and colour. @param {{ decision: DecisionName }} props */
export function DecisionBadge({ decision }) {
  return h(Badge, { kind: KINDS[decision], children: common[decision] });
}

/**
 * The current decision, and the three that can be made.
 * @param {{ iteration: Iteration, etag: string | undefined, reason?: string | null | undefined,
 *   put: (iteration: Iteration, etag: string | undefined) => void, reload: () => void }} props
 *   `reason`: of the current decision
 */
export function Decision({ iteration, etag, reason, put, reload }) {
  const [decision, setDecision] = useState(/** @type {DecisionName | null} */ (null));
  const likely = objectionsOf(iteration).length === 0 ? "accepted" : "remachine";
  return html`<section class="panel" aria-labelledby="decision">
    <h2 id="decision">${t.decision}</h2>
    <p>${iteration.decision ? h(DecisionBadge, { decision: iteration.decision }) : html`<span class="quiet">${t.none}</span>`}
      ${reason && html` <span translate="no">${reason}</span>`}</p>
    ${h(Allowed, {
      scope: "decide",
      short: true,
      children: () => html`<div class="actions">
        ${ORDER.map(
          (one) => html`<button key=${one} type="button" class=${`button${one === likely ? " primary" : ""}`}
            onClick=${() => setDecision(one)}>${t[one]}</button>`,
        )}
      </div>`,
    })}
    ${decision && h(ConfirmDecision, { key: decision, decision, iteration, etag, put, reload, onClose: () => setDecision(null) })}
  </section>`;
}

/**
 * @param {{ decision: DecisionName, iteration: Iteration, etag: string | undefined,
 *   put: (iteration: Iteration, etag: string | undefined) => void, reload: () => void, onClose: () => void }} props
 */
function ConfirmDecision({ decision, iteration, etag, put, reload, onClose }) {
  const [reason, setReason, forget] = useDraft(
    `decision ${iteration.job_id} ${iteration.number} ${decision}`,
    () => "",
  );
  const [error, setError] = useState(/** @type {unknown} */ (undefined));
  const [sending, setSending] = useState(false);
  const overtaken = error instanceof ApiError && error.status === 412;
  const objections = decision === "accepted" ? objectionsOf(iteration) : [];
  // the version at the beginning of a decision: a newer one is shown before it is overruled
  const [begun] = useState(etag);
  const send = async (/** @type {Event} */ event) => {
    event.preventDefault();
    setSending(true);
    try {
      const body = { decision, ...(reason.trim() ? { reason: reason.trim() } : {}) };
      const path = { job_id: iteration.job_id, number: iteration.number };
      const known = overtaken ? etag : begun;
      const header = known ? { "If-Match": known } : {};
      const done = await answer(api.PATCH("/v1/jobs/{job_id}/iterations/{number}", { params: { path, header }, body }));
      forget();
      put(done.data, done.etag);
      notify(t.done(common[decision]));
      onClose();
    } catch (caught) {
      setError(caught);
      setSending(false);
      if (caught instanceof ApiError && caught.status === 412) {
        announce(common.changedMeanwhile);
        reload();
      }
    }
  };
  return h(Dialog, {
    title: titleOf(decision, iteration.number),
    onClose,
    children: html`<form onSubmit=${send}>
      ${
        overtaken
          ? html`<div class="failure" role="alert"><h3>${common.changedMeanwhile}</h3>
              <dl class="facts"><div><dt>${t.decidedNow}</dt><dd>${iteration.decision ? h(DecisionBadge, { decision: iteration.decision }) : t.none}</dd></div>
              <div><dt>${t.yours}</dt><dd>${h(DecisionBadge, { decision })} <span translate="no">${reason}</span></dd></div></dl></div>`
          : error !== undefined && h(Failure, { error, except: ["/reason"] })
      }
      ${
        objections.length > 0 &&
        html`<div class="notice warn" data-objections><ul>${objections.map((one) => html`<li key=${one}>${one}</li>`)}</ul>
          <p>${t.concession}</p></div>`
      }
      ${h(TextField, { label: t.reason, hint: t.reasonHint, required: objections.length > 0, value: reason, onInput: setReason, lines: 3, maxLength: 4000, error, pointer: "/reason" })}
      ${h(
        Fragment,
        null,
        html`<div class="actions">
          <button type="submit" class=${`button ${decision === "rejected" ? "danger" : "primary"}`} disabled=${sending}>${overtaken ? t.anyway(t[decision]) : t[decision]}</button>
          <button type="button" class="button" onClick=${onClose}>${common.cancel}</button>
        </div>`,
      )}
    </form>`,
  });
}

/** Objections to accepting, one sentence each. @param {Iteration} iteration @returns {string[]} */
function objectionsOf(iteration) {
  const figures = iteration.fits.find(({ chosen }) => chosen)?.figures;
  const outside = figureRows(figures).flatMap(({ symbol, figure }) => {
    const { verdict, limits_um: [low = 0, high = 0] = [] } = figure.conformity ?? {};
    if (verdict !== "does_not_conform") return [];
    const by = fmt.value.um(Math.max(low - figure.value, figure.value - high));
    return [t.outside(symbol.replace("_", "\u202f"), by)];
  });
  const warned = (/** @type {string} */ code) => figures?.warnings.some((warning) => warning.code === code);
  return [
    ...outside,
    ...(warned("implausible_unit") ? [t.implausible] : []),
    ...(warned("outliers_suspected") ? [t.outliers] : []),
  ];
}

/** @param {DecisionName} decision @param {number} number */
function titleOf(decision, number) {
  if (decision === "accepted") return t.sureAccept(number);
  return decision === "remachine" ? t.sureRemachine(number) : t.sureReject(number);
}
