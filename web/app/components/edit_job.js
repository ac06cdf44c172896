// Changes a job, as long as nobody else has changed it; else both versions are shown.

import { answer, api } from "../api/client.js";
import { ApiError } from "../api/problem.js";
import { t as common } from "../i18n/common.js";
import de from "../i18n/de/job.js";
import en from "../i18n/en/job.js";
import { fmt, texts } from "../i18n/i18n.js";
import { ABSENT } from "../lib/format.js";
import { FIELDS, formOf, gearOf, tagLines, tagsOf } from "../lib/gear_form.js";
import { h, html, useState } from "../../vendor/ui.js";
import { Dialog } from "./dialog.js";
import { Checkbox } from "./form.js";
import { GearFields } from "./gear_fields.js";
import { JobFields, OPTIONAL } from "./job_fields.js";
import { Failure } from "./states.js";
import { table } from "./table.js";
import { notify } from "./toast.js";

/** @typedef {import("../api/job.js").Job} Job */
/** @typedef {import("../api/client.js").Schema<"JobPatch">} JobPatch */
/** @typedef {{ data: Job, etag: string | undefined }} Version */

const t = texts({ en, de });
const SHOWN = [
  "/name",
  "/part_number",
  "/serial_number",
  "/machine",
  "/tags",
  ...Object.values(FIELDS).map(({ pointer }) => `/gear${pointer}`),
];

/** @param {{ version: Version, onClose: () => void, onSaved: (version: Version) => void }} props */
export function EditJob({ version, onClose, onSaved }) {
  const [base, setBase] = useState(version);
  const [job, setJob] = useState(() => fieldsOf(version.data));
  const [withGear, setWithGear] = useState(version.data.gear != null);
  const [gear, setGear] = useState(() => formOf(version.data.gear ?? undefined, fmt.value.input));
  const [told, setTold] = useState(false);
  const [error, setError] = useState(/** @type {unknown} */ (undefined));
  const [theirs, setTheirs] = useState(/** @type {Version | undefined} */ (undefined));
  const [sending, setSending] = useState(false);
  const params = { path: { job_id: version.data.id } };

  const save = async (/** @type {Version} */ over) => {
    const read = patchOf(job, withGear ? gear : undefined, over.data);
    setTold(true);
    if (!read) return;
    setSending(true);
    setError(undefined);
    try {
      const header = over.etag === undefined ? {} : { "If-Match": over.etag };
      const saved = await answer(api.PATCH("/v1/jobs/{job_id}", { params: { ...params, header }, body: read }));
      notify(t.saved);
      onSaved(saved);
    } catch (failed) {
      if (failed instanceof ApiError && failed.status === 412) {
        await answer(api.GET("/v1/jobs/{job_id}", { params })).then(setTheirs, setError);
      } else setError(failed);
      setSending(false);
    }
  };
  const submit = (/** @type {Event} */ event) => {
    event.preventDefault();
    save(base);
  };
  const takeTheirs = () => {
    if (!theirs) return;
    setBase(theirs);
    setJob(fieldsOf(theirs.data));
    setWithGear(theirs.data.gear != null);
    setGear(formOf(theirs.data.gear ?? undefined, fmt.value.input));
    setTheirs(undefined);
  };
  const keepMine = () => {
    if (!theirs) return;
    setBase(theirs);
    setTheirs(undefined);
    save(theirs);
  };

  const body = theirs
    ? h(Conflict, {
        mine: describe(job, withGear ? gearOf(gear).gear : undefined),
        stored: describe(fieldsOf(theirs.data), theirs.data.gear),
        takeTheirs,
        keepMine,
      })
    : html`<form onSubmit=${submit} novalidate>
        ${h(JobFields, { form: job, onChange: setJob, error, told })}
        ${h(Checkbox, { label: t.gear, checked: withGear, onChange: setWithGear })}
        ${withGear && h(GearFields, { form: gear, onChange: setGear, error, at: "/gear", told })}
        ${error !== undefined && h(Failure, { error, except: SHOWN })}
        <div class="actions">
          <button type="submit" class="button primary" disabled=${sending}>${common.save}</button>
          <button type="button" class="button" onClick=${onClose}>${common.cancel}</button>
        </div>
      </form>`;
  return h(Dialog, { title: t.edit, onClose, wide: true, children: body });
}

/** @typedef {{ name: string, value: string }} Described */

/** @param {{ mine: Described[], stored: Described[], takeTheirs: () => void, keepMine: () => void }} props */
function Conflict({ mine, stored, takeTheirs, keepMine }) {
  const rows = mine
    .map(({ name, value }, i) => ({ name, mine: value, stored: stored[i]?.value ?? ABSENT }))
    .filter((row) => row.mine !== row.stored);
  const data = (/** @type {string} */ text) => html`<span translate="no">${text}</span>`;
  return html`<div role="alert"><p>${t.conflict}</p></div>
    ${table({
      caption: common.changedMeanwhile,
      hideCaption: true,
      rows,
      rowKey: ({ name }) => name,
      columns: [
        { key: "name", header: t.field, rowHeader: true, cell: ({ name }) => name },
        { key: "mine", header: t.yours, cell: (row) => data(row.mine) },
        { key: "stored", header: t.stored, cell: (row) => data(row.stored) },
      ],
    })}
    <div class="actions">
      <button type="button" class="button primary" onClick=${keepMine}>${t.keepMine}</button>
      <button type="button" class="button" onClick=${takeTheirs}>${t.takeTheirs}</button>
    </div>`;
}

/** @param {Job} job */
function fieldsOf(job) {
  return {
    name: job.name,
    part_number: job.part_number ?? "",
    serial_number: job.serial_number ?? "",
    machine: job.machine ?? "",
    tags: tagLines(job.tags),
  };
}

/** @param {ReturnType<typeof fieldsOf>} job @param {import("../lib/gear_form.js").Gear | null | undefined} gear @returns {Described[]} */
function describe(job, gear) {
  const written = Object.entries(gear ?? {}).map(
    ([name, value]) => `${name}: ${typeof value === "number" ? fmt.value.input(value) : JSON.stringify(value)}`,
  );
  return [
    { name: t.name, value: job.name },
    { name: t.part, value: job.part_number || ABSENT },
    { name: t.serial, value: job.serial_number || ABSENT },
    { name: t.machine, value: job.machine || ABSENT },
    { name: t.tags, value: job.tags.replaceAll("\n", "; ") || ABSENT },
    { name: t.gear, value: written.sort().join("; ") || ABSENT },
  ];
}

/**
 * What is to be changed of a job; none where something of the form cannot be read.
 * @param {ReturnType<typeof fieldsOf>} job @param {import("../lib/gear_form.js").GearForm | undefined} gearForm @param {Job} before
 * @returns {JobPatch | undefined}
 */
function patchOf(job, gearForm, before) {
  const tags = tagsOf(job.tags);
  const gear = gearForm === undefined ? undefined : gearOf(gearForm).gear;
  if (job.name.trim() === "" || !tags || (gearForm !== undefined && !gear)) return undefined;
  /** @type {JobPatch} */
  const patch = { name: job.name.trim(), tags };
  /** @type {NonNullable<JobPatch["clear"]>} */
  const clear = [];
  for (const name of OPTIONAL) {
    const value = job[name].trim();
    if (value !== "") patch[name] = value;
    else if (before[name]) clear.push(name);
  }
  if (gear) patch.gear = gear;
  else if (before.gear) clear.push("gear");
  if (clear.length > 0) patch.clear = clear;
  return patch;
}
