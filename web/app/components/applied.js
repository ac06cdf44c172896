// The changes entered on the machine after a correction: the newest entry, and the form for another.

import { useAttempt } from "../api/attempt.js";
import { answer, api } from "../api/client.js";
import { t } from "../i18n/correction.js";
import { fmt } from "../i18n/i18n.js";
import { useDraft } from "../lib/draft.js";
import { ABSENT, parseNumber } from "../lib/format.js";
import { escaped, isSuperseded, newValue, presentOf } from "../lib/correction.js";
import { h, html, useId, useState } from "../../vendor/ui.js";
import { Allowed } from "./allowed.js";
import { proposedText, settingName, unitOf } from "./correction_result.js";
import { TextField } from "./form.js";
import { Failure } from "./states.js";
import { table } from "./table.js";
import { notify } from "./toast.js";

/** @typedef {import("../api/client.js").Schema<"Correction">} Correction */
/** @typedef {import("../api/client.js").Schema<"AppliedChanges">} AppliedChanges */
/** @typedef {import("../api/client.js").Schema<"Job">} Job */
/** @typedef {import("../lib/correction.js").Present} Present */
/** @typedef {{ settings: Record<string, string>, note: string }} Draft as it was typed */

/**
 * @param {{ job: Job, number: number | undefined, kept: Correction, onDone: () => void }} props `number`: of the corrected
 *   iteration; none of the gear
 */
export function Applied({ job, number, kept, onDone }) {
  const { applied } = kept;
  const form = h(Allowed, {
    scope: "measure",
    children: () => h(AppliedForm, { key: `${kept.id} ${applied?.id}`, job, number, kept, onDone }),
  });
  if (!applied) return html`<p class="quiet">${t.enteredAbout}</p>${form}`;
  return html`${h(Entry, { applied })}
    <details class="another"><summary>${t.enterAgain}</summary>${form}</details>`;
}

/** @param {{ applied: AppliedChanges }} props */
function Entry({ applied }) {
  const { value } = fmt;
  const data = (/** @type {string} */ text) => html`<span translate="no">${text}</span>`;
  return html`<p>${t.enteredAt} ${data(value.time(applied.created_at))}${applied.by && html` ${t.enteredBy} ${data(applied.by)}`}</p>
    ${applied.note && html`<p translate="no">${applied.note}</p>`}
    ${table({
      caption: t.entered,
      hideCaption: true,
      stacked: true,
      rows: applied.settings,
      rowKey: ({ name }) => name,
      columns: [
        { key: "name", header: t.setting, rowHeader: true, cell: ({ name }) => settingName(name) },
        {
          key: "entered",
          header: t.entered,
          numeric: true,
          cell: ({ change, unit }) => html`<b translate="no">${signed(change)}${unitOf(unit)}</b>`,
        },
        {
          key: "proposed",
          header: t.proposed,
          numeric: true,
          cell: ({ proposed, unit }) => data(`${signed(proposed)}${unitOf(unit)}`),
        },
      ],
    })}`;
}

/** @param {number} change */
const signed = (change) => `${change > 0 ? "+" : ""}${fmt.value.three(change)}`;

/** @param {{ job: Job, number: number | undefined, kept: Correction, onDone: () => void }} props */
function AppliedForm({ job, number, kept, onDone }) {
  const { settings } = kept.result;
  const [present, setPresent] = useDraft(`present of job ${job.id}`, noPresent, true);
  const superseded = settings.some(({ name }) => isSuperseded(present[name], kept.id, Boolean(kept.applied)));
  const proposed = Object.fromEntries(settings.map((setting) => [setting.name, proposedText(setting)]));
  const [draft, setDraft, forget] = useDraft(`applied ${kept.id}`, () => beginning(kept.applied, proposed));
  const [error, setError] = useState(/** @type {unknown} */ (undefined));
  const [shown, setShown] = useState(/** @type {ReadonlySet<string>} */ (new Set()));
  const [busy, setBusy] = useState(false);
  const attempt = useAttempt(`applied ${kept.id}`);
  const newOf = (/** @type {string} */ name) => newValue(presentOf(present[name], kept.id), draft.settings[name] ?? "");
  /** The values before and after this correction, once it is entered. @param {{ name: string }} setting @returns {[string, Present]} */
  const entered = ({ name }) => {
    const before = presentOf(present[name], kept.id);
    return [name, { correction: kept.id, present: before, next: fmt.value.input(newOf(name)) }];
  };
  const setBefore = (/** @type {string} */ name, /** @type {string} */ text) => {
    // after the correction was entered, its change is on the machine
    const change = kept.applied && beginning(kept.applied, proposed).settings[name];
    const next = change === undefined ? text : fmt.value.input(newValue(text, change));
    setPresent({ ...present, [name]: { correction: kept.id, present: text, next } });
  };
  const send = async (/** @type {Event} */ event) => {
    event.preventDefault();
    if (busy) return;
    // a text equal to the proposal means that the change was entered as proposed
    const changed = settings
      .map(({ name }) => ({ name, text: draft.settings[name] ?? "" }))
      .filter(({ name, text }) => text.trim() !== proposed[name])
      .map(({ name, text }) => ({ name, value: parseNumber(text) }));
    const wrong = changed.filter(({ value }) => value === undefined || Number.isNaN(value)).map(({ name }) => name);
    setShown(new Set(wrong));
    setError(undefined);
    if (wrong.length > 0) {
      notify(t.lookAgain, "failed");
      return;
    }
    setBusy(true);
    try {
      const note = draft.note.trim();
      const body = {
        settings: Object.fromEntries(changed.map(({ name, value }) => [name, value ?? 0])),
        ...(note ? { note } : {}),
      };
      const header = attempt.headers(body);
      if (number === undefined) {
        const params = { path: { job_id: job.id }, header };
        await answer(api.POST("/v1/jobs/{job_id}/correction/applied", { params, body }));
      } else {
        const params = { path: { job_id: job.id, number }, header };
        await answer(api.POST("/v1/jobs/{job_id}/iterations/{number}/correction/applied", { params, body }));
      }
      attempt.done();
      if (!superseded) setPresent({ ...present, ...Object.fromEntries(settings.map(entered)) });
      forget();
      notify(t.enteredDone);
      onDone();
    } catch (failed) {
      setError(failed);
    } finally {
      setBusy(false);
    }
  };
  const known = ["/note", ...settings.map(({ name }) => `/settings/${escaped(name)}`)];
  return html`<form onSubmit=${send} novalidate>
    ${!superseded && html`<p class="quiet">${t.presentAbout}</p>`}
    <div>
      ${settings.map(({ name, unit }) =>
        h(Setting, {
          key: name,
          name,
          unit: unitOf(unit).trim(),
          change: draft.settings[name] ?? "",
          onChange: (text) => setDraft({ ...draft, settings: { ...draft.settings, [name]: text } }),
          present: superseded ? undefined : presentOf(present[name], kept.id),
          onPresent: (text) => setBefore(name, text),
          value: newOf(name),
          error,
          fieldError: shown.has(name) ? t.notNumber : undefined,
        }),
      )}
    </div>
    ${h(TextField, {
      label: t.enteredNote,
      lines: 2,
      maxLength: 4000,
      value: draft.note,
      error,
      pointer: "/note",
      onInput: (note) => setDraft({ ...draft, note }),
    })}
    ${error !== undefined && h(Failure, { error, except: known })}
    <div class="actions">
      <button type="submit" class="button primary" aria-disabled=${busy ? "true" : undefined}>${t.enterSave}</button>
    </div>
  </form>`;
}

/** @returns {Record<string, Present>} */
const noPresent = () => ({});

/**
 * The change of a setting, with the values before and after it, unless `present` is undefined.
 * @param {{ name: string, unit: string, change: string, onChange: (text: string) => void, present: string | undefined,
 *   onPresent: (text: string) => void, value: number | undefined, error: unknown, fieldError: string | undefined }} props
 */
function Setting({ name, unit, change, onChange, present, onPresent, value, error, fieldError }) {
  const id = useId();
  const words = settingName(name);
  const field = { numeric: true, required: true, unit };
  return html`<div class="limits entered-setting" role="group" aria-label=${words}>
    <p class="limits-name"><b translate=${words === name ? "no" : undefined}>${words}</b></p>
    ${h(TextField, { ...field, label: t.change, value: change, onInput: onChange, error, pointer: `/settings/${escaped(name)}`, fieldError })}
    ${
      present !== undefined &&
      html`${h(TextField, {
        ...field,
        required: false,
        label: t.present,
        value: present,
        onInput: onPresent,
        fieldError: Number.isNaN(parseNumber(present)) ? t.notNumber : undefined,
      })}
        <div class="field">
          <label for=${id}>${t.newValue}</label>
          <output id=${id}>${value === undefined ? ABSENT : html`<b translate="no">${fmt.value.input(value)}</b> <span class="unit" translate="no">${unit}</span>`}</output>
        </div>`
    }
  </div>`;
}

/** Initial values of the form: the last entry, or the proposal. @param {AppliedChanges | null | undefined} applied @param {Record<string, string>} proposed @returns {Draft} */
function beginning(applied, proposed) {
  const entered = (applied?.settings ?? [])
    .filter(({ change, proposed: of }) => change !== of)
    .map(({ name, change }) => [name, fmt.value.input(change)]);
  return { settings: { ...proposed, ...Object.fromEntries(entered) }, note: "" };
}
