// Changes a job, unless somebody else has changed it; then both versions are shown.

import { answer, api } from "../api/client.js";
import { ApiError } from "../api/problem.js";
import { t as common } from "../i18n/common.js";
import de from "../i18n/de/job.js";
import en from "../i18n/en/job.js";
import { fmt, texts } from "../i18n/i18n.js";
import { useDraft } from "../lib/draft.js";
import { ABSENT } from "../lib/format.js";
import { FIELDS, gearOf } from "../lib/gear_form.js";
import { editOf, patchOf, rebased } from "../lib/job_edit.js";
import { t as requirementText } from "../i18n/requirements.js";
import { ALL_FIGURES, limitsOf, requirementsOf, SIDES } from "../lib/requirements.js";
import { h, html, useRef, useState } from "../../vendor/ui.js";
import { Dialog } from "./dialog.js";
import { Checkbox, toFirstError } from "./form.js";
import { GearFields } from "./gear_fields.js";
import { JobFields } from "./job_fields.js";
import { RequirementsFields, shownPointers } from "./requirements_fields.js";
import { Failure } from "./states.js";
import { table } from "./table.js";
import { notify } from "./toast.js";

/** @typedef {import("../api/job.js").Job} Job */
/** @typedef {import("../lib/job_edit.js").JobEdit} JobEdit */
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
  const [mine, setMine, forget] = useDraft(`edit ${version.data.id} ${version.data.updated_at}`, () => read(version));
  const [submitted, setSubmitted] = useState(false);
  const [error, setError] = useState(/** @type {unknown} */ (undefined));
  const [theirs, setTheirs] = useState(/** @type {Version | undefined} */ (undefined));
  const [sending, setSending] = useState(false);
  const form = useRef(/** @type {HTMLFormElement | null} */ (null));
  const params = { path: { job_id: version.data.id } };
  const { job, gear, withGear, requirements } = mine;

  const save = async (/** @type {JobEdit} */ edit, /** @type {Version} */ over) => {
    const body = patchOf(edit, read(over));
    setSubmitted(true);
    if (!body) return toFirstError(form.current);
    if (Object.keys(body).length === 0) {
      onSaved(over);
      return;
    }
    setSending(true);
    setError(undefined);
    try {
      const header = over.etag === undefined ? {} : { "If-Match": over.etag };
      const saved = await answer(api.PATCH("/v1/jobs/{job_id}", { params: { ...params, header }, body }));
      forget();
      notify(t.saved);
      onSaved(saved);
    } catch (failed) {
      if (failed instanceof ApiError && failed.status === 412) {
        await answer(api.GET("/v1/jobs/{job_id}", { params })).then(setTheirs, setError);
      } else {
        setError(failed);
        toFirstError(form.current);
      }
      setSending(false);
    }
  };
  const close = () => {
    forget();
    onClose();
  };
  const submit = (/** @type {Event} */ event) => {
    event.preventDefault();
    save(mine, base);
  };
  /** @param {Version} stored @param {JobEdit} edit */
  const goOn = (stored, edit) => {
    setBase(stored);
    setMine(edit);
    setTheirs(undefined);
  };
  const keepMine = () => {
    if (!theirs) return;
    const edit = rebased(mine, read(base), read(theirs));
    goOn(theirs, edit);
    save(edit, theirs);
  };

  const body = theirs
    ? h(Conflict, {
        rows: rowsOf(mine, read(base), read(theirs)),
        takeTheirs: () => goOn(theirs, read(theirs)),
        keepMine,
      })
    : html`<form ref=${form} onSubmit=${submit} novalidate>
        ${h(JobFields, { form: job, onChange: (form) => setMine({ ...mine, job: form }), error, submitted })}
        ${h(Checkbox, { label: t.gear, checked: withGear, onChange: (on) => setMine({ ...mine, withGear: on }) })}
        ${withGear && h(GearFields, { form: gear, onChange: (form) => setMine({ ...mine, gear: form }), error, at: "/gear", submitted })}
        <section class="edit-requirements" aria-labelledby="edit-requirements">
          <h3 id="edit-requirements">${requirementText.title}</h3>
          ${h(RequirementsFields, { form: requirements, onChange: (form) => setMine({ ...mine, requirements: form }), error, submitted })}
        </section>
        ${error !== undefined && h(Failure, { error, except: [...SHOWN, ...shownPointers(requirements)] })}
        <div class="actions">
          <button type="submit" class="button primary" disabled=${sending}>${common.save}</button>
          <button type="button" class="button" onClick=${close}>${common.cancel}</button>
        </div>
      </form>`;
  return h(Dialog, { title: t.edit, onClose: close, wide: true, children: body });
}

/** @param {Version} version */
const read = ({ data }) => editOf(data, fmt.value.input);

/** @typedef {{ name: string, mine: string | undefined, stored: string }} Row `mine`: none where the user did not touch it */

/** @param {{ rows: Row[], takeTheirs: () => void, keepMine: () => void }} props */
function Conflict({ rows, takeTheirs, keepMine }) {
  const data = (/** @type {string} */ text) => html`<span translate="no">${text}</span>`;
  return html`<div role="alert"><p>${t.conflict}</p></div>
    ${table({
      caption: common.changedMeanwhile,
      hideCaption: true,
      rows,
      rowKey: ({ name }) => name,
      columns: [
        { key: "name", header: t.field, rowHeader: true, cell: ({ name }) => name },
        { key: "mine", header: t.yours, cell: ({ mine }) => (mine === undefined ? t.notTouched : data(mine)) },
        { key: "stored", header: t.stored, cell: ({ stored }) => data(stored) },
      ],
    })}
    <p class="quiet">${t.keepMineText}</p>
    <div class="actions">
      <button type="button" class="button primary" onClick=${keepMine}>${t.keepMine}</button>
      <button type="button" class="button" onClick=${takeTheirs}>${t.takeTheirs}</button>
    </div>`;
}

/** Returns the differences of the two versions. @param {JobEdit} mine @param {JobEdit} from @param {JobEdit} theirs @returns {Row[]} */
function rowsOf(mine, from, theirs) {
  const [own, begun, stored] = [describe(mine), describe(from), describe(theirs)];
  return own.flatMap(({ name, value }, i) => {
    const [before = ABSENT, now = ABSENT] = [begun[i]?.value, stored[i]?.value];
    return value === now ? [] : [{ name, mine: value === before ? undefined : value, stored: now }];
  });
}

/** @param {JobEdit} edit */
function describe({ job, gear, withGear, requirements }) {
  const written = Object.entries((withGear && gearOf(gear).gear) || {}).map(
    ([name, value]) => `${name}: ${typeof value === "number" ? fmt.value.input(value) : JSON.stringify(value)}`,
  );
  return [
    { name: t.name, value: job.name },
    { name: t.part, value: job.part_number || ABSENT },
    { name: t.serial, value: job.serial_number || ABSENT },
    { name: t.machine, value: job.machine || ABSENT },
    { name: t.tags, value: job.tags.replaceAll("\n", "; ") || ABSENT },
    { name: t.gear, value: written.sort().join("; ") || ABSENT },
    { name: requirementText.title, value: inShort(requirements) || ABSENT },
  ];
}

/** Describes requirements in a line. @param {import("../lib/requirements.js").RequirementsForm} form */
function inShort(form) {
  const { requirements } = requirementsOf(form);
  const of = requirements?.tolerance_limits?.class;
  const limits = SIDES.flatMap((side) =>
    ALL_FIGURES.flatMap(({ name, symbol }) => {
      const ends = limitsOf(requirements, side, name)?.map(fmt.value.input).join(" … ");
      const whose = side === "both" ? "" : `, ${requirementText[side]}`;
      return ends ? [`${symbol.replace("_", " ")}${whose}: ${ends}`] : [];
    }),
  );
  const bands = (requirements?.k_bands ?? []).map(
    ({ kind, upper, lower }) =>
      `${requirementText[kind]}: ${[upper, lower].map((line) => JSON.stringify(line)).join(" ")}`,
  );
  const ofPitch = requirements?.pitch_limits?.class;
  const classes = [
    ...(of === undefined ? [] : [`${requirementText.class}: ${of}`]),
    ...(ofPitch === undefined ? [] : [`${requirementText.pitchClass}: ${ofPitch}`]),
  ];
  return [...classes, ...limits, ...bands].join("; ");
}
