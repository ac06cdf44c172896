// The correction of the gear on the page of its job: from all teeth measured since the last one.

import { useAttempt } from "../api/attempt.js";
import { answer, api } from "../api/client.js";
import { useResource } from "../api/resource.js";
import { t } from "../i18n/correction.js";
import { fmt } from "../i18n/i18n.js";
import { h, html, useState } from "../../vendor/ui.js";
import { Allowed } from "./allowed.js";
import { Applied } from "./applied.js";
import { ControlCsv } from "./control_csv.js";
import { Answer, Indistinguishable, Changes, Figures, factsOf, ofFlank } from "./correction_result.js";
import { Facts } from "./figure.js";
import { SelectField } from "./form.js";
import { Failure, loaded } from "./states.js";
import { notify } from "./toast.js";
import { WarningList } from "./warnings.js";

/** @typedef {import("../api/client.js").Schema<"Correction">} Correction */
/** @typedef {import("../api/job.js").Job} Job */
/** @typedef {import("../api/job.js").TracedIteration} TracedIteration */
/** @typedef {"form_grinding" | "generating_grinding"} Machine */

const SIDES = /** @type {const} */ (["left", "right"]);

/** The panel; absent for a job without a gear or without a flank. @param {{ job: Job, iterations: readonly TracedIteration[], onDone: () => void }} props */
export function GearCorrection({ job, iterations, onDone }) {
  const made = iterations.flatMap(({ records }) => (records ?? []).filter(({ kind }) => kind === "gear_correction"));
  const [latest] = made.sort((a, b) => b.created_at.localeCompare(a.created_at));
  const last = iterations.at(-1)?.number;
  const kept = useResource(latest ? `gear correction ${job.id} ${latest.id} ${last}` : null, async (signal) => {
    const params = { path: { job_id: job.id } };
    const { data } = await answer(api.GET("/v1/jobs/{job_id}/correction", { signal, params }));
    return { data: /** @type {Correction} */ (data) };
  });
  if (!job.gear || !iterations.some(({ flank }) => flank)) return null;
  const form = h(Allowed, {
    scope: "decide",
    children: () => h(NewCorrection, { job, last: machineOf(kept.data), onDone }),
  });
  return html`<section class="panel" aria-labelledby="gear-correction">
    <h2 id="gear-correction">${t.gearTitle}</h2>
    <p class="quiet">${t.gearAbout}</p>
    ${
      latest
        ? html`${loaded({
            resource: kept,
            lines: 6,
            children: (correction) => h(Kept, { job, kept: correction, onApplied: kept.reload }),
          })}
          <details class="another"><summary>${t.another}</summary>${form}</details>`
        : form
    }
  </section>`;
}

/** Returns the machine of the previous correction. @param {Correction | undefined} kept @returns {Machine} */
const machineOf = (kept) => (kept?.method === "generating_grinding" ? kept.method : "form_grinding");

/** @param {{ job: Job, last: Machine, onDone: () => void }} props */
function NewCorrection({ job, last, onDone }) {
  const [machine, setMachine] = useState(/** @type {Machine | undefined} */ (undefined));
  const [error, setError] = useState(/** @type {unknown} */ (undefined));
  const [busy, setBusy] = useState(false);
  const attempt = useAttempt(`gear correction ${job.id}`);
  const send = async (/** @type {Event} */ event) => {
    event.preventDefault();
    if (busy) return;
    setBusy(true);
    setError(undefined);
    try {
      const body = { sensitivity: { type: /** @type {const} */ ("machine"), machine: machine ?? last } };
      const params = { path: { job_id: job.id }, header: attempt.headers(body) };
      await answer(api.POST("/v1/jobs/{job_id}/correction", { params, body }));
      attempt.done();
      notify(t.done);
      onDone();
    } catch (failed) {
      setError(failed);
    } finally {
      setBusy(false);
    }
  };
  return html`<form onSubmit=${send} novalidate>
    <div class="fields">
      ${h(SelectField, {
        label: t.gearMethod,
        required: true,
        value: machine ?? last,
        error,
        pointer: "/sensitivity/machine",
        onChange: (value) => setMachine(/** @type {Machine} */ (value)),
        options: /** @type {const} */ (["form_grinding", "generating_grinding"]).map((value) => ({
          value,
          label: t[value],
        })),
      })}
    </div>
    ${error !== undefined && h(Failure, { error, except: ["/sensitivity/machine"] })}
    <div class="actions">
      <button type="submit" class="button primary" aria-disabled=${busy ? "true" : undefined}>${t.gearMake}</button>
    </div>
  </form>`;
}

/** @param {{ job: Job, kept: Correction, onApplied: () => void }} props */
function Kept({ job, kept, onApplied }) {
  const { result, answer: measured, not_compared: refused } = kept;
  const { value } = fmt;
  const um = (/** @type {number | null | undefined} */ number) => value.um(number);
  const teeth = SIDES.flatMap((side) => {
    const own = result.teeth?.[side];
    if (!own) return [];
    const spread = own.spread_um == null ? undefined : `${um(own.spread_um)}\u202fµm`;
    return [{ name: t[`flank_${side}`], value: t.gearTeeth(own.iterations.length, spread) }];
  });
  const { rms_before_um: before, rms_um: after } = result.predicted;
  const rms = html`<span translate="no">${um(before)} → ${um(after)}\u202fµm</span>`;
  const items = [...factsOf(kept), ...teeth, { name: t.rms, value: rms }];
  const tools = h(ControlCsv, { owner: encodeURIComponent(job.id), name: `${job.name} ${t.gearTitle}`, result });
  return html`
    ${h(Facts, { items })}
    ${h(Changes, { result, csvName: `${job.name} ${t.gearTitle}`, tools, of: t.gearTitle })}
    ${result.warnings.length > 0 && h(WarningList, { warnings: result.warnings })}
    ${result.indistinguishable.length > 0 && h(Indistinguishable, { result })}
    ${SIDES.map((side) => {
      const own = result.figures?.[side];
      if (!own) return null;
      const of = t[`flank_${side}`];
      return html`<h3 key=${side}>${measured ? t.figures : t.figuresBefore}: ${of}</h3>
        ${h(Figures, { kept: ofFlank(kept, side, own, measured?.flanks?.[side]), of })}`;
    })}
    <h3>${t.enteredTitle}</h3>
    ${h(Applied, { job, number: undefined, kept, onDone: onApplied })}
    ${measured && html`<h3>${t.answered}</h3>${h(Answer, { answer: measured, entered: Boolean(kept.applied) })}`}
    ${!measured && refused && html`<p>${t.notCompared} <span lang="en">${refused}</span></p>`}`;
}
