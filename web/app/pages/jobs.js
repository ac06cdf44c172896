// All jobs, newest first, 50 a page.

import { answer, api } from "../api/client.js";
import { useResource } from "../api/resource.js";
import { Tags } from "../components/tags.js";
import { Page } from "../components/page.js";
import { Empty, loaded } from "../components/states.js";
import { table } from "../components/table.js";
import de from "../i18n/de/jobs.js";
import en from "../i18n/en/jobs.js";
import { t as common } from "../i18n/common.js";
import { fmt, texts } from "../i18n/i18n.js";
import { gearInShort } from "../lib/gear.js";
import { ABSENT } from "../lib/format.js";
import { query } from "../navigation.js";
import { href, hrefIf } from "../router.js";
import { h, html } from "../../vendor/ui.js";

/** @typedef {import("../api/client.js").Schema<"Job">} Job */

const t = texts({ en, de });
const ON_A_PAGE = 50;

export default function Jobs() {
  const cursor = query.value.get("cursor") ?? undefined;
  const list = useResource(`jobs ${cursor ?? ""}`, (signal) =>
    answer(api.GET("/v1/jobs", { signal, params: { query: { limit: ON_A_PAGE, ...(cursor ? { cursor } : {}) } } })),
  );
  const toCreate = hrefIf("/jobs/new");
  const create = toCreate && html`<a class="button primary" href=${toCreate}>${common.newJob}</a>`;
  return h(Page, {
    title: t.title,
    about: t.about,
    actions: create,
    children: loaded({
      resource: list,
      lines: 12,
      children: ({ items, next_cursor }) =>
        items.length === 0
          ? h(Empty, { children: cursor ? t.emptyPage : t.none, action: cursor ? toNewest() : create })
          : html`${h(List, { jobs: items })}${h(Pages, { cursor, next: next_cursor })}`,
    }),
  });
}

/** @param {{ jobs: readonly Job[] }} props */
function List({ jobs }) {
  /** @type {readonly import("../components/table.js").Column<Job>[]} */
  const columns = [
    { key: "name", header: t.name, rowHeader: true, cell: jobLink, csv: (job) => job.name },
    { key: "part", header: t.part, cell: (job) => named(job.part_number), csv: (job) => job.part_number },
    { key: "serial", header: t.serial, cell: (job) => named(job.serial_number), csv: (job) => job.serial_number },
    { key: "machine", header: t.machine, cell: (job) => named(job.machine), csv: (job) => job.machine },
    { key: "gear", header: t.gear, cell: (job) => named(gearInShort(job.gear)), csv: (job) => gearInShort(job.gear) },
    { key: "tags", header: t.tags, cell: (job) => h(Tags, { tags: job.tags }), csv: (job) => tagText(job.tags) },
    {
      key: "changed",
      header: t.changed,
      numeric: true,
      cell: (job) => html`<time datetime=${job.updated_at} translate="no">${fmt.value.time(job.updated_at)}</time>`,
      csv: (job) => job.updated_at,
    },
  ];
  return table({
    caption: t.caption,
    hideCaption: true,
    columns,
    rows: jobs,
    rowKey: (job) => job.id,
    csvName: "jobs",
    stacked: true,
  });
}

/** @param {Job} job */
function jobLink(job) {
  const to = hrefIf("/jobs/{job_id}", { job_id: job.id });
  const name = html`<span translate="no">${job.name}</span>`;
  return to ? html`<a href=${to}>${name}</a>` : name;
}

/** @param {string | null | undefined} value */
function named(value) {
  return value ? html`<span translate="no">${value}</span>` : ABSENT;
}

/** @param {Record<string, string>} tags */
const tagText = (tags) =>
  Object.entries(tags)
    .map(([name, value]) => `${name}=${value}`)
    .join("; ");

/** @param {{ cursor: string | undefined, next: string | null | undefined }} props */
function Pages({ cursor, next }) {
  if (!cursor && !next) return null;
  return html`<nav class="actions end" aria-label=${t.pages}>
    ${cursor && toNewest()}
    ${next && html`<a class="button" rel="next" href=${href("/jobs", {}, { cursor: next })}>${t.older}</a>`}
  </nav>`;
}

const toNewest = () => html`<a class="button" href=${href("/jobs")}>${t.newest}</a>`;
