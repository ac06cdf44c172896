// The frame of all pages of a job: its name, its gear, navigation between its views.

import { useJob, useTrace } from "../api/job.js";
import { useJobEvents } from "../api/live.js";
import { useOpenStreams } from "../api/stream.js";
import { t as common } from "../i18n/common.js";
import { gearInShort } from "../lib/gear.js";
import { current, navigate, pathname, query } from "../navigation.js";
import { href, hrefIf } from "../router.js";
import { Fragment, h, html, useEffect, useState } from "../../vendor/ui.js";
import { JobNavigation, Page } from "./page.js";
import { useShortcut } from "./shortcuts.js";
import { loaded } from "./states.js";

/** @typedef {import("../../vendor/ui.js").ComponentChildren} Children */
/** @typedef {import("../api/job.js").Job} Job */
/** @typedef {import("../api/job.js").WholeTrace} WholeTrace */
/** @typedef {import("../api/resource.js").Resource<Job>} JobResource */
/** @typedef {import("../api/resource.js").Resource<WholeTrace>} TraceResource */

/**
 * @param {{
 *   jobId: string,
 *   view?: string,
 *   number?: number | undefined,
 *   onEvents?: (events: import("../api/live.js").JobEvent[]) => void,
 *   actions?: (job: Job, resources: { job: JobResource, trace: TraceResource }) => Children,
 *   children: (job: Job, resources: { job: JobResource, trace: TraceResource, news: number }) => Children,
 * }} props `view`: the name of the page, next to the job's; `number`: the iteration that it shows; `onEvents`: somebody has
 *   done something to the job (or may have, without events). The trace may still be on
 *   its way when the children are drawn; `news` grows with every event, for `useNews`
 */
export function JobPage({ jobId, view, number, actions, onEvents, children }) {
  const job = useJob(jobId);
  const trace = useTrace(jobId);
  const [news, setNews] = useState(0);
  const streams = useOpenStreams(jobId);
  useJobEvents(job.data === undefined ? null : jobId, (events) => {
    // blocks of a stream, possibly many a second, change neither
    if (events.length === 0 || events.some(({ state }) => state !== "block")) {
      job.reload();
      trace.reload();
      if (events.length > 0) setNews((last) => last + 1);
    }
    if (events.length === 0 || events.some(({ stream_id: id, state }) => id && state !== "block")) streams.reload();
    onEvents?.(events);
  });
  const numbers = trace.data?.iterations.map((iteration) => iteration.number) ?? [];
  const step = (/** @type {number} */ by) => {
    const at = number === undefined ? (by > 0 ? -1 : numbers.length) : numbers.indexOf(number);
    const to = numbers[at + by];
    // the same page may show another iteration with the same query, for example on that of λ*
    const view = number === undefined ? undefined : current.value?.page.path;
    const seen = view ? Object.fromEntries(query.value) : {};
    const path = view ?? "/jobs/{job_id}/iterations/{number}";
    if (to !== undefined) navigate(href(path, { job_id: jobId, number: to }, seen));
  };
  useShortcut(
    "[",
    () => common.previousIteration,
    () => step(-1),
  );
  useShortcut(
    "]",
    () => common.nextIteration,
    () => step(1),
  );
  const toJobs = html`<a href=${href("/jobs")}>${common.jobs}</a>`;
  const name = job.data?.name ?? common.job;
  return h(Page, {
    title: view ? `${view} – ${name}` : name,
    heading: job.data ? html`<span translate="no">${name}</span>` : name,
    above: toJobs,
    about: job.data && h(About, { job: job.data }),
    actions: job.data && actions?.(job.data, { job, trace }),
    children: loaded({
      resource: job,
      back: html`<a class="button" href=${href("/jobs")}>${common.backToJobs}</a>`,
      children: (data) =>
        h(
          Fragment,
          null,
          h(JobNavigation, { jobId, number, iterations: numbers }),
          streams.data?.map((stream) => h(Streaming, { key: stream.id, jobId, stream })),
          children(data, { job, trace, news }),
        ),
    }),
  });
}

/**
 * Reloads resources that others may have changed.
 * @param {number} news of the page @param {readonly { reload: () => void }[]} resources
 */
export function useNews(news, resources) {
  useEffect(() => {
    if (news > 0) for (const { reload } of resources) reload();
  }, [news]);
}

/** Links to the streams being measured. @param {{ jobId: string, stream: import("../api/client.js").Schema<"ListedStream"> }} props */
function Streaming({ jobId, stream: { id, flank, tooth } }) {
  const to = hrefIf("/jobs/{job_id}/streams/{stream_id}", { job_id: jobId, stream_id: id });
  if (!to || to === pathname.value) return null;
  return html`<p class="note" role="status">${flank ? common.streamingFlank(flank, tooth ?? "") : common.streaming}${" "}
    <a href=${to}>${common.watch}</a></p>`;
}

/** @param {{ job: Job }} props */
function About({ job }) {
  const parts = [
    job.part_number && html`${common.part} <b translate="no">${job.part_number}</b>`,
    job.serial_number && html`${common.serial} <b translate="no">${job.serial_number}</b>`,
    job.machine && html`${common.machine} <b translate="no">${job.machine}</b>`,
    job.gear && html`<span translate="no">${gearInShort(job.gear)}</span>`,
  ].filter(Boolean);
  return html`<span class="about-parts">${parts.map((part, i) => html`<span key=${i}>${part}</span>`)}</span>`;
}
