// Stores fitted nodes as the next iteration of a job.

import { useAttempt } from "../api/attempt.js";
import { answer, api } from "../api/client.js";
import { useResource } from "../api/resource.js";
import { useWatched } from "../api/watched.js";
import { t as common } from "../i18n/common.js";
import de from "../i18n/de/fit.js";
import en from "../i18n/en/fit.js";
import { fmt, texts } from "../i18n/i18n.js";
import { digestOf } from "../lib/digest.js";
import { useDraft } from "../lib/draft.js";
import { useLeaving } from "../lib/leaving.js";
import { navigate } from "../navigation.js";
import { href, hrefIf } from "../router.js";
import { h, html, useRef, useState } from "../../vendor/ui.js";
import { SelectField, TextField } from "./form.js";
import { Empty, Failure, loaded } from "./states.js";
import { notify } from "./toast.js";
import { stopNote, Underway } from "./underway.js";

/** @typedef {import("../api/client.js").Schema<"Job">} Job */
/** @typedef {import("../lib/nodes_file.js").NodesFile} NodesFile */
/** @typedef {import("../lib/nodes_file.js").Fields} Fields */

const t = texts({ en, de });
const MOST_OFFERED = 50;
const FIELDS = /** @type {const} */ (["instrument", "operator", "note"]);

/** The words that find a job, and the one that was chosen. @typedef {{ find: string, jobId: string }} Target */

/** @param {{ file: NodesFile, spec: Fields, target: Target, setTarget: (target: Target) => void }} props */
export function SaveIteration({ file, spec, target, setTarget }) {
  const q = target.find.trim();
  const jobs = useResource(`jobs to choose ${q}`, (signal) =>
    answer(api.GET("/v1/jobs", { signal, params: { query: { limit: MOST_OFFERED, ...(q ? { q } : {}) } } })),
  );
  // previous results stay until the next are there
  const last = useRef(jobs.data);
  if (jobs.data) last.current = jobs.data;
  return html`<section class="panel save-iteration" aria-labelledby="save">
    <h2 id="save">${t.save}</h2>
    ${loaded({
      resource: { ...jobs, data: jobs.data ?? last.current },
      lines: 3,
      children: ({ items }) =>
        items.length === 0 && q === ""
          ? h(Empty, {
              children: t.noJobs,
              action: { label: common.newJob, to: toNewJob() },
            })
          : h(Save, { key: digestOf(file.text), jobs: items, target, setTarget, file, spec }),
    })}
  </section>`;
}

/** Creates a job and returns; it is then the one changed last. */
const toNewJob = () => `${href("/jobs/new")}?then=fit`;

/** @param {Job} job */
const jobName = ({ name, serial_number, updated_at }) =>
  [name, serial_number, fmt.value.date(updated_at)].filter(Boolean).join(" · ");

/** @param {{ jobs: readonly Job[], target: Target, setTarget: (target: Target) => void, file: NodesFile, spec: Fields }} props */
function Save({ jobs, target, setTarget, file, spec }) {
  const { find, jobId: chosen } = target;
  // the first result, unless another is chosen
  const jobId = jobs.some(({ id }) => id === chosen) ? chosen : (jobs[0]?.id ?? "");
  const [typed, setTyped, forget] = useDraft(`save ${digestOf(file.text)}`, () =>
    Object.fromEntries(FIELDS.map((name) => [name, String(file.measurement[name] ?? "")])),
  );
  const [error, setError] = useState(/** @type {unknown} */ (undefined));
  const [sending, setSending] = useState(false);
  const attempt = useAttempt("save of /fit");
  const watched = useWatched();
  const leaving = useLeaving();
  const submit = async (/** @type {Event} */ event) => {
    event.preventDefault();
    if (sending || jobId === "") return;
    setSending(true);
    setError(undefined);
    const measurement = { ...file.measurement };
    for (const name of FIELDS) {
      if (typed[name]?.trim()) measurement[name] = typed[name].trim();
      else delete measurement[name];
    }
    try {
      const header = attempt.headers([jobId, spec, measurement, file.text]);
      const { data } = await watched.run(
        (how) =>
          api.POST("/v1/jobs/{job_id}/iterations", {
            ...how,
            params: { path: { job_id: jobId }, header },
            ...bodyOf(file, { ...spec, ...measurement }),
          }),
        leaving,
      );
      attempt.done();
      forget();
      notify(t.saved(data.number));
      if (leaving.aborted) return;
      const to = hrefIf("/jobs/{job_id}/iterations/{number}", { job_id: jobId, number: data.number });
      navigate(to ?? href("/jobs/{job_id}", { job_id: jobId }));
    } catch (failed) {
      setSending(false);
      const stopped = stopNote(failed);
      if (stopped) notify(stopped, "news");
      else setError(failed);
    }
  };
  const line = (/** @type {(typeof FIELDS)[number]} */ name) =>
    h(TextField, {
      key: name,
      label: t[name],
      value: typed[name] ?? "",
      onInput: (value) => setTyped({ ...typed, [name]: value }),
      error,
      pointer: `/${name}`,
      ...(name === "note" ? { lines: 2 } : { maxLength: 200 }),
    });
  return html`<form onSubmit=${submit}>
    <p class="quiet">${t.saveText}</p>
    <div class="fields">
      ${h(TextField, { label: t.findJob, hint: t.findJobHint, type: "search", value: find, onInput: (text) => setTarget({ ...target, find: text }), maxLength: 200 })}
      ${h(SelectField, {
        label: common.job,
        required: true,
        fieldError: jobs.length === 0 ? t.noSuchJob : undefined,
        value: jobId,
        onChange: (id) => setTarget({ ...target, jobId: id }),
        options: jobs.map((job) => ({ value: job.id, label: html`<span translate="no">${jobName(job)}</span>` })),
      })}
      ${FIELDS.map(line)}
    </div>
    ${error !== undefined && h(Failure, { error, except: FIELDS.map((name) => `/${name}`) })}
    ${h(Underway, { watched, label: t.save })}
    <div class="actions"><button type="submit" class="button primary" disabled=${sending || jobId === ""}>${t.saveNow}</button><a class="button" href=${toNewJob()}>${common.newJob}</a></div>
  </form>`;
}

/** A request with nodes. @param {NodesFile} file @param {Fields} spec */
export function bodyOf(file, spec) {
  const body = /** @type {unknown} */ ({ ...spec, nodes: file.nodes });
  return { body: /** @type {import("../api/client.js").Schema<"IterationRequest">} */ (body) };
}
