// A new job: its names, and the gear with its derived quantities.

import { useAttempt } from "../api/attempt.js";
import { answer, api } from "../api/client.js";
import { may } from "../api/key.js";
import { ApiError } from "../api/problem.js";
import { Allowed } from "../components/allowed.js";
import { Checkbox, toFirstError } from "../components/form.js";
import { Derived, emptyGear, GearFields } from "../components/gear_fields.js";
import { GearFile } from "../components/gear_file.js";
import { emptyJob, JobFields } from "../components/job_fields.js";
import { Page } from "../components/page.js";
import { RequirementsFields, shownPointers } from "../components/requirements_fields.js";
import { Failure } from "../components/states.js";
import { notify } from "../components/toast.js";
import { t as common } from "../i18n/common.js";
import de from "../i18n/de/new_job.js";
import en from "../i18n/en/new_job.js";
import { fmt, texts } from "../i18n/i18n.js";
import { t as requirementText } from "../i18n/requirements.js";
import { useDraft } from "../lib/draft.js";
import { FIELDS, formOf, gearOf, tagsOf } from "../lib/gear_form.js";
import { OPTIONAL } from "../lib/job_edit.js";
import { useLeaving } from "../lib/leaving.js";
import { emptyRequirements, requirementsOf } from "../lib/requirements.js";
import { navigate, query } from "../navigation.js";
import { href } from "../router.js";
import { h, html, useRef, useState } from "../../vendor/ui.js";

/** @typedef {import("../api/client.js").Schema<"NewJob">} NewJob */

const t = texts({ en, de });
const SHOWN = [
  "/name",
  "/part_number",
  "/serial_number",
  "/machine",
  "/tags",
  ...Object.values(FIELDS).map(({ pointer }) => `/gear${pointer}`),
];

export const styles = ["new_job"];

export default function NewJob() {
  return may("measure")
    ? h(Form, null)
    : h(Page, {
        title: t.title,
        above: html`<a href=${href("/jobs")}>${common.jobs}</a>`,
        children: h(Allowed, { scope: "measure", children: () => null }),
      });
}

function Form() {
  const [draft, setDraft, forget] = useDraft("new job with requirements", () => ({
    job: emptyJob,
    withGear: true,
    gear: emptyGear(),
    requirements: emptyRequirements(),
  }));
  const { job, withGear, gear, requirements } = draft;
  const [begun] = useState(() => requirementsOf(requirements).requirements !== undefined);
  const setJob = (/** @type {typeof emptyJob} */ next) => setDraft({ ...draft, job: next });
  const setWithGear = (/** @type {boolean} */ next) => setDraft({ ...draft, withGear: next });
  const setGear = (/** @type {import("../lib/gear_form.js").GearForm} */ next) => setDraft({ ...draft, gear: next });
  const [submitted, setSubmitted] = useState(false);
  const [sending, setSending] = useState(false);
  const [error, setError] = useState(/** @type {unknown} */ (undefined));
  const attempt = useAttempt("new job");
  const leaving = useLeaving();
  // a gear of a file resets the fields: those that it fills are not folded
  const [taken, setTaken] = useState(0);
  const form = useRef(/** @type {HTMLFormElement | null} */ (null));

  const submit = async (/** @type {Event} */ event) => {
    event.preventDefault();
    const body = read(job, withGear ? gear : undefined, requirements);
    setSubmitted(true);
    if (!body) return toFirstError(form.current);
    setSending(true);
    setError(undefined);
    try {
      const header = attempt.headers(body);
      const { data } = await answer(api.POST("/v1/jobs", { signal: leaving, body, params: { header } }));
      attempt.done();
      forget();
      notify(t.created(data.name));
      navigate(query.value.get("then") === "fit" ? href("/fit") : href("/jobs/{job_id}", { job_id: data.id }));
    } catch (failed) {
      if (leaving.aborted) return notify(common.cancelled, "news");
      setError(failed);
      setSending(false);
      if (failed instanceof ApiError) toFirstError(form.current);
    }
  };
  const take = (/** @type {import("../lib/gear_form.js").Gear} */ found, /** @type {string | undefined} */ name) => {
    const named = name && job.name === "" ? { ...job, name } : job;
    setDraft({ ...draft, job: named, gear: formOf(found, fmt.value.input) });
    setTaken(taken + 1);
  };

  return h(Page, {
    title: t.title,
    about: t.about,
    above: html`<a href=${href("/jobs")}>${common.jobs}</a>`,
    children: html`<form class="new-job" ref=${form} onSubmit=${submit} novalidate>
      <div class="new-job-fields">
        <section class="panel" aria-labelledby="new-job">
          <h2 id="new-job">${t.job}</h2>
          ${h(JobFields, { form: job, onChange: setJob, error, submitted })}
        </section>
        <section class="panel" aria-labelledby="new-gear">
          <header>
            <h2 id="new-gear">${t.gear}</h2>
            ${h(Checkbox, { label: t.withGear, checked: withGear, onChange: setWithGear })}
          </header>
          ${
            withGear
              ? html`${h(GearFile, { onTake: take })}${h(GearFields, { key: taken, form: gear, onChange: setGear, error, at: "/gear", submitted })}`
              : html`<p class="quiet">${t.gearAbout}</p>`
          }
        </section>
        <section class="panel" aria-labelledby="new-requirements">
          <h2 id="new-requirements">${requirementText.title}</h2>
          <p class="quiet">${t.requirementsAbout}</p>
          <details open=${begun}>
            <summary>${t.requirementsNow}</summary>
            ${h(RequirementsFields, { form: requirements, onChange: (form) => setDraft({ ...draft, requirements: form }), error, submitted })}
          </details>
        </section>
        ${error !== undefined && h(Failure, { error, except: [...SHOWN, ...shownPointers(requirements)] })}
        <div class="actions">
          <button type="submit" class="button primary" disabled=${sending}>${t.create}</button>
          <a class="button" href=${href("/jobs")}>${common.cancel}</a>
        </div>
      </div>
      ${withGear && h(Derived, { form: gear })}
    </form>`,
  });
}

/**
 * Returns the request of a form, unless it is invalid.
 * @param {typeof emptyJob} job @param {import("../lib/gear_form.js").GearForm | undefined} gearForm
 * @param {import("../lib/requirements.js").RequirementsForm} requirementsForm
 * @returns {NewJob | undefined}
 */
function read(job, gearForm, requirementsForm) {
  const tags = tagsOf(job.tags);
  const gear = gearForm === undefined ? undefined : gearOf(gearForm).gear;
  if (job.name.trim() === "" || !tags || (gearForm !== undefined && !gear)) return undefined;
  const { requirements, errors } = requirementsOf(requirementsForm);
  if (Object.keys(errors).length > 0) return undefined;
  /** @type {NewJob} */
  const body = { name: job.name.trim() };
  for (const name of OPTIONAL) if (job[name].trim() !== "") body[name] = job[name].trim();
  if (Object.keys(tags).length > 0) body.tags = tags;
  if (gear) body.gear = gear;
  if (requirements) body.requirements = requirements;
  return body;
}
