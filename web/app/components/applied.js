// The changes entered on the machine after a correction: the newest entry, and the form for another.

import { useAttempt } from "../api/attempt.js";
import { answer, api } from "../api/client.js";
import { t } from "../i18n/correction.js";
import { fmt } from "../i18n/i18n.js";
import { useDraft } from "../lib/draft.js";
import { parseNumber } from "../lib/format.js";
import { escaped } from "../lib/correction.js";
import { h, html, useState } from "../../vendor/ui.js";
import { Allowed } from "./allowed.js";
import { proposedText, settingName, unitOf } from "./correction_result.js";
import { TextField } from "./form.js";
import { Failure } from "./states.js";
import { table } from "./table.js";
import { notify } from "./toast.js";

/** @typedef {import("../api/client.js").Schema<"KeptCorrection">} KeptCorrection */
/** @typedef {import("../api/client.js").Schema<"AppliedChanges">} AppliedChanges */
/** @typedef {{ settings: Record<string, string>, note: string }} Draft as it was typed */

/** @param {{ jobId: string, number: number | undefined, kept: KeptCorrection, onDone: () => void }} props `number`: of the corrected iteration; none of the gear */
export function Applied({ jobId, number, kept, onDone }) {
  const { applied } = kept;
  const form = h(Allowed, {
    scope: "measure",
    children: () => h(AppliedForm, { key: `${kept.id} ${applied?.id}`, jobId, number, kept, onDone }),
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

/** @param {{ jobId: string, number: number | undefined, kept: KeptCorrection, onDone: () => void }} props */
function AppliedForm({ jobId, number, kept, onDone }) {
  const { settings } = kept.result;
  const proposed = Object.fromEntries(settings.map((setting) => [setting.name, proposedText(setting)]));
  const [draft, setDraft, forget] = useDraft(`applied ${kept.id}`, () => beginning(kept.applied, proposed));
  const [error, setError] = useState(/** @type {unknown} */ (undefined));
  const [shown, setShown] = useState(/** @type {ReadonlySet<string>} */ (new Set()));
  const [busy, setBusy] = useState(false);
  const attempt = useAttempt(`applied ${kept.id}`);
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
        const params = { path: { job_id: jobId }, header };
        await answer(api.POST("/v1/jobs/{job_id}/correction/applied", { params, body }));
      } else {
        const params = { path: { job_id: jobId, number }, header };
        await answer(api.POST("/v1/jobs/{job_id}/iterations/{number}/correction/applied", { params, body }));
      }
      attempt.done();
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
    <div class="fields correction-fields">
      ${settings.map(({ name, unit }) =>
        h(TextField, {
          key: name,
          label: settingName(name),
          // its sign is too small to be read alone
          unit: unit === "arcmin" ? unit : unitOf(unit).trim(),
          required: true,
          numeric: true,
          value: draft.settings[name] ?? "",
          error,
          pointer: `/settings/${escaped(name)}`,
          fault: shown.has(name) ? t.notNumber : undefined,
          onInput: (text) => setDraft({ ...draft, settings: { ...draft.settings, [name]: text } }),
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

/** Initial values of the form: the last entry, or the proposal. @param {AppliedChanges | null | undefined} applied @param {Record<string, string>} proposed @returns {Draft} */
function beginning(applied, proposed) {
  const entered = (applied?.settings ?? [])
    .filter(({ change, proposed: of }) => change !== of)
    .map(({ name, change }) => [name, fmt.value.input(change)]);
  return { settings: { ...proposed, ...Object.fromEntries(entered) }, note: "" };
}
