// Measuring: dropped, chosen or pasted files are previewed and become iterations.

import { Attempt } from "../api/attempt.js";
import { answer, api } from "../api/client.js";
import { OfflineError } from "../api/problem.js";
import { withProgress } from "../api/progress.js";
import { Allowed } from "../components/allowed.js";
import { useResource } from "../api/resource.js";
import { JobPage } from "../components/job_page.js";
import { measurandInWords } from "../components/measurand_fields.js";
import { announce, notify } from "../components/toast.js";
import { t as common } from "../i18n/common.js";
import de from "../i18n/de/measure.js";
import en from "../i18n/en/measure.js";
import { texts } from "../i18n/i18n.js";
import { QueueEntry } from "../measure/entry.js";
import { MeasureFields } from "../measure/fields.js";
import { proposed } from "../measure/read.js";
import { contentOf, started } from "../measure/reader.js";
import { isJson } from "../lib/nodes_file.js";
import { namesAxes, readTable } from "../lib/nodes_table.js";
import { EMPTY, answered, wrongNumbers } from "../measure/request.js";
import { ChangedError, send } from "../measure/send.js";
import { navigate } from "../navigation.js";
import { hrefIf } from "../router.js";
import { h, html, useEffect, useRef, useState } from "../../vendor/ui.js";

/** @typedef {import("../measure/entry.js").Entry} Entry */
/** @typedef {import("../measure/request.js").Typed} Typed */

const t = texts({ en, de });
export const styles = ["measure"];

/** Pointers of errors that are shown at fields. */
const FIELDS = [
  "flank",
  "tooth",
  "component",
  "instrument",
  "operator",
  "measured_at",
  "axes",
  "note",
  "model",
  "estimator",
  "regularization",
  "filters",
].flatMap((name) => [`/${name}`, `/spec/${name}`]);

/** @param {{ params: Record<string, string> }} props */
export default function MeasurePage({ params }) {
  const jobId = params["job_id"] ?? "";
  return h(JobPage, {
    jobId,
    view: common.measure,
    children: (job, { trace }) =>
      h(Allowed, { scope: "measure", children: () => h(Measure, { jobId, gear: job.gear, reread: trace.reload }) }),
  });
}

/** @param {{ jobId: string, gear: import("../measure/likely.js").Gear | null | undefined, reread: () => void }} props */
function Measure({ jobId, gear, reread }) {
  const [typed, change] = useTyped(jobId);
  const [entries, setEntries] = useState(/** @type {Entry[]} */ ([]));
  const [over, setOver] = useState(false);
  const underway = useRef(/** @type {AbortController | null} */ (null));
  const last = useRef(0);
  const health = useResource("health", (signal) => answer(api.GET("/healthz", { signal })));
  const most = health.data?.body_limit_bytes ?? Number.POSITIVE_INFINITY;
  useEffect(() => {
    started();
    return () => underway.current?.abort();
  }, []);
  const update = (/** @type {number} */ id, /** @type {Partial<Entry>} */ next) =>
    setEntries((all) => all.map((one) => (one.id === id ? { ...one, ...next } : one)));
  const add = (/** @type {Iterable<File>} */ files) => {
    for (const file of files) {
      last.current += 1;
      const id = last.current;
      /** @type {Entry} */
      const entry = {
        id,
        file,
        content: undefined,
        gears: undefined,
        state: "waiting",
        error: undefined,
        number: undefined,
        progress: undefined,
        attempt: new Attempt(`measure ${jobId} ${file.name} ${file.size}`),
      };
      setEntries((all) => [...all, entry]);
      look(file).then((found) => update(id, found));
    }
  };
  const paste = () => {
    if (typed.text.trim() === "") return;
    add([new File([typed.text], isJson(typed.text) ? t.pastedJson : t.pastedCsv, { lastModified: 0 })]);
  };
  const waiting = entries.filter(
    ({ file, state, content }) => state !== "done" && state !== "sending" && file.size <= most && sendable(content),
  );
  const busy = entries.some(({ state }) => state === "sending");
  const wrong = wrongNumbers(typed);
  const submit = async (/** @type {Event} */ event) => {
    event.preventDefault();
    if (busy || Object.keys(wrong).length > 0) return;
    /** @type {number[]} */
    const made = [];
    for (const { id, file, content, attempt } of waiting) {
      if (!content) continue;
      const abort = new AbortController();
      underway.current = abort;
      update(id, { state: "sending", error: undefined, progress: undefined });
      const how = { signal: abort.signal, fetch: withProgress((progress) => update(id, { progress })) };
      try {
        const { data } = await send(
          jobId,
          file,
          content,
          answered(typed, content, { name: file.name, gear }),
          attempt,
          how,
        );
        attempt.done();
        made.push(data.number);
        update(id, { state: "done", number: data.number });
        announce(t.stored(data.number));
      } catch (error) {
        if (abort.signal.aborted) {
          update(id, { state: "waiting" });
          notify(common.cancelled, "news");
          break;
        }
        update(id, { state: "failed", error });
        if (!(error instanceof ChangedError)) announce(error instanceof OfflineError ? t.noAnswer : t.refused);
        break;
      }
    }
    const left = underway.current?.signal.aborted;
    underway.current = null;
    if (made.length === 0) return;
    reread();
    change({ text: "", note: "" });
    if (entries.length === 1) {
      notify(t.stored(made[0] ?? 0));
      const to = hrefIf("/jobs/{job_id}/iterations/{number}", { job_id: jobId, number: made[0] ?? 0 });
      if (to && !left) navigate(to);
    }
  };
  const drop = (/** @type {DragEvent} */ event) => {
    event.preventDefault();
    setOver(false);
    add(event.dataTransfer?.files ?? []);
  };
  const next = waiting.find(({ content }) => content?.kind !== "import") ?? entries.at(-1);
  const likely = next?.content ? answered(typed, next.content, { name: next.file.name, gear }) : typed;
  const named = namesAxes(next?.content?.proposal);
  const kinds = entries.map(({ content }) => content?.kind);
  const failed = entries.find(({ state }) => state === "failed");
  return html`<form class="measure" onSubmit=${submit}>
    <section class=${`panel drop${over ? " over" : ""}`} aria-labelledby="drop" onDrop=${drop}
      onDragOver=${(/** @type {DragEvent} */ event) => {
        event.preventDefault();
        setOver(true);
      }} onDragLeave=${() => setOver(false)}>
      <h2 id="drop">${t.drop}</h2>
      <p class="quiet">${t.kinds}</p>
      <div class="actions">
        <label class="button primary" for="measure-files">${t.pick}</label>
        <input class="visually-hidden" id="measure-files" type="file" multiple
          onChange=${(/** @type {import("../../vendor/ui.js").TargetedEvent<HTMLInputElement>} */ event) => {
            add([...(event.currentTarget.files ?? [])]);
            event.currentTarget.value = "";
          }} />
      </div>
      <details open=${typed.text !== ""}>
        <summary>${t.paste}</summary>
        <div class="field">
          <label for="measure-text">${t.pasteHere}</label>
          <textarea id="measure-text" rows="6" spellcheck=${false} value=${typed.text}
            onInput=${(/** @type {import("../../vendor/ui.js").TargetedEvent<HTMLTextAreaElement>} */ event) => change({ text: event.currentTarget.value })}></textarea>
          <div class="actions"><button type="button" class="button" disabled=${typed.text.trim() === ""} onClick=${paste}>${t.take}</button></div>
        </div>
      </details>
    </section>
    ${
      entries.length > 0 &&
      html`<ul class="queue" aria-label=${t.queue}>
        ${entries.map((entry) =>
          h(QueueEntry, {
            key: entry.id,
            entry,
            most,
            jobId,
            fields: FIELDS,
            onRemove: () => setEntries((all) => all.filter(({ id }) => id !== entry.id)),
            onCancel: () => underway.current?.abort(),
            onMapping: (mapping) => {
              const { content, file } = entry;
              if (content)
                table(file, content, mapping).then((found) => update(entry.id, { error: undefined, ...found }));
            },
          }),
        )}
      </ul>`
    }
    <section class="panel">
      ${h(MeasureFields, {
        typed: likely,
        said: named || kinds.includes("json") ? undefined : measurandInWords(next?.content?.surface, likely),
        named,
        change,
        error: failed?.error,
        wrong,
        imports: kinds.includes("import"),
        fits: kinds.length === 0 || kinds.some((kind) => kind !== "import"),
        fromFile: kinds.includes("json"),
      })}
    </section>
    <div class="actions">
      <button type="submit" class="button primary" disabled=${busy || waiting.length === 0}>${t.send(waiting.length)}</button>
      ${waiting.length === 0 && !busy && html`<span class="hint">${t.nothingYet}</span>`}
    </div>
  </form>`;
}

/** Returns the contents of a file, with its gears if it has some. @param {File} file @returns {Promise<Partial<Entry>>} */
async function look(file) {
  /** @type {import("../measure/read.js").Content} */
  let content;
  try {
    content = await contentOf(file);
  } catch (error) {
    return { state: "failed", error };
  }
  if (content.kind === "table") return table(file, content, undefined);
  if (content.failure !== undefined || !["rexs", "mka", "mew"].includes(content.form)) return { content };
  const form = new FormData();
  form.append("file", file, file.name);
  const sent = api.POST("/v1/gears/read", { body: { file: file.name }, bodySerializer: () => form });
  return answer(sent).then(
    ({ data }) => ({ content, gears: data }),
    (/** @type {unknown} */ error) => ({ content, error }),
  );
}

/**
 * Adds the server's interpretation to a table.
 * @param {File} file @param {import("../measure/read.js").Content} content
 * @param {import("../lib/nodes_table.js").Mapping | undefined} mapping @returns {Promise<Partial<Entry>>}
 */
async function table(file, content, mapping) {
  try {
    return { content: proposed(content, await readTable(file, mapping)) };
  } catch (error) {
    return { content: content.proposal ? content : { ...content, failure: "table" }, error };
  }
}

/** @param {Entry["content"]} content */
function sendable(content) {
  return content !== undefined && content.failure === undefined && content.kind !== "values";
}

/** The input, kept until it has been sent, also over reloads. @param {string} jobId @returns {[Typed, (change: Partial<Typed>) => void]} */
function useTyped(jobId) {
  const place = `flankfit.measure.${jobId}`;
  const [typed, setTyped] = useState(() => {
    try {
      return { ...EMPTY, .../** @type {Partial<Typed>} */ (JSON.parse(sessionStorage.getItem(place) ?? "{}")) };
    } catch {
      return EMPTY;
    }
  });
  useEffect(() => {
    try {
      sessionStorage.setItem(place, JSON.stringify(typed));
    } catch {
      // without storage it is kept until the tab is closed
    }
  }, [typed]);
  return [typed, (next) => setTyped((before) => ({ ...before, ...next }))];
}
