// The list of jobs as a table, with the result of each one's last iteration.

import { Badge } from "../components/figure.js";
import { table } from "../components/table.js";
import { Tags } from "../components/tags.js";
import { Thumbnail } from "../components/thumbnail.js";
import { Decided } from "../components/within.js";
import { t } from "../i18n/jobs.js";
import { fmt } from "../i18n/i18n.js";
import { ABSENT } from "../lib/format.js";
import { gearInShort } from "../lib/gear.js";
import { SURFACE_FIGURES } from "../lib/requirements.js";
import { commonLimit } from "../lib/thumbnail.js";
import { setQuery } from "../navigation.js";
import { href } from "../router.js";
import { compact, hidden } from "../settings.js";
import { h, html } from "../../vendor/ui.js";
import { firstPage } from "./filters.js";

/** @typedef {import("../api/client.js").Schema<"ListedJob">} ListedJob */
/** @typedef {import("../components/table.js").Column<ListedJob>} Column */

const KINDS = /** @type {const} */ ({
  new: "plain",
  open: "news",
  remachine: "warn",
  accepted: "good",
  rejected: "bad",
});

/** @param {{ jobs: readonly ListedJob[], sort: string, tools: import("../components/table.js").Children }} props */
export function JobList({ jobs, sort, tools }) {
  const limit = commonLimit(jobs);
  const flanks = jobs.some(({ figures }) => figures) && shows("flank");
  const list = table({
    caption: t.caption,
    hideCaption: true,
    // hidden columns are in the file too
    columns: columns(sort, flanks ? limit : undefined).map((column) =>
      shows(column.key) ? column : { ...column, cell: undefined },
    ),
    rows: jobs,
    rowKey: (job) => job.id,
    csvName: "jobs",
    stacked: true,
    tools,
  });
  return html`<div class=${`job-list${compact.value ? " compact" : ""}`} style=${{ "--hidden": hidden.value.length }}>${list}</div>${flanks && html`<p class="hint list-hint">${t.flankHint(fmt.value.input(limit))}</p>`}`;
}

/** Returns true if the list shows a column. @param {string} key */
export const shows = (key) => !hidden.value.includes(key);

/** The columns that can be hidden. */
export const optionalColumns = () => columns("", 0).filter(({ cell, rowHeader }) => cell && !rowHeader);

/** @param {string} sort @param {number | undefined} limit of the flanks' colours; none where no job has one @returns {Column[]} */
function columns(sort, limit) {
  const by = (/** @type {string | undefined} */ value) => () => setQuery({ sort: value, ...firstPage }, { step: true });
  return [
    {
      key: "name",
      header: t.name,
      rowHeader: true,
      cell: nameOf,
      csv: (job) => job.name,
      sorted: sort === "name" ? "ascending" : undefined,
      onSort: by("name"),
    },
    {
      key: "part",
      header: t.part,
      cell: (job) => data(job.part_number),
      csv: (job) => job.part_number,
      minor: true,
    },
    {
      key: "serial",
      header: t.serial,
      cell: (job) => data(job.serial_number),
      csv: (job) => job.serial_number,
      minor: true,
    },
    { key: "machine", header: t.machine, cell: (job) => data(job.machine), csv: (job) => job.machine },
    {
      key: "status",
      header: t.status,
      cell: statusOf,
      csv: ({ status }) => t[status],
    },
    {
      key: "iterations",
      header: t.iterations,
      numeric: true,
      cell: ({ iteration_count: count }) => html`<span translate="no">${fmt.value.count(count)}</span>`,
      csv: (job) => job.iteration_count,
      minor: true,
    },
    {
      key: "flank",
      header: t.flank,
      cell:
        limit === undefined ? undefined : ({ figures, flank }) => (figures ? flankOf(figures, flank, limit) : ABSENT),
      csv: ({ flank }) => flank && t[flank],
    },
    ...SURFACE_FIGURES.map(({ name, symbol }) => {
      const value = (/** @type {ListedJob} */ { figures }) => figures?.[/** @type {const} */ (`${name}_um`)];
      return { key: name, header: symbol.replace("_", " "), unit: "µm", csv: value };
    }),
    { key: "within", header: t.withinLimits, csv: ({ figures }) => figures?.within },
    {
      key: "class",
      header: t.class,
      numeric: true,
      cell: ({ class: of }) => (of === undefined ? ABSENT : html`<span translate="no">${fmt.value.count(of)}</span>`),
      csv: (job) => job.class,
    },
    number("rms", t.rms, ({ rms }) => rms, fmt.value.three),
    { ...number("condition", t.condition, ({ condition }) => condition, fmt.value.condition), minor: true },
    { key: "gear", header: t.gear, csv: (job) => gearInShort(job.gear) },
    { key: "tags", header: t.tags, csv: (job) => tagText(job.tags) },
    { key: "measured", header: t.measured, csv: (job) => job.last_measured_at },
    { key: "created", header: t.created, csv: (job) => job.created_at },
    {
      key: "changed",
      header: t.changed,
      numeric: true,
      cell: (job) => html`<time datetime=${job.changed_at} translate="no">${fmt.value.time(job.changed_at)}</time>`,
      csv: (job) => job.changed_at,
      sorted: sort === "changed" ? "descending" : undefined,
      onSort: by(undefined),
    },
  ];
}

/** The flank, and the worst verdict of its figures. @param {NonNullable<ListedJob["figures"]>} figures @param {ListedJob["flank"]} flank @param {number} limit */
function flankOf(figures, flank, limit) {
  const { verdict, assumptions } = figures;
  const conformity = verdict && assumptions && { verdict, assumptions, reasons: [] };
  return html`<span class="flank-cell">${h(Thumbnail, { figures, flank, limit })}${h(Decided, { conformity })}${
    flank && html`<span class="flank-side" aria-hidden="true">${t[flank]}</span>`
  }</span>`;
}

/** @param {string} key @param {string} header @param {(job: ListedJob) => number | undefined} of @param {(value: number | undefined) => string} write @returns {Column} */
function number(key, header, of, write) {
  const cell = (/** @type {ListedJob} */ job) => {
    const value = of(job);
    return value === undefined ? ABSENT : html`<span translate="no">${write(value)}</span>`;
  };
  return { key, header, numeric: true, cell, csv: of };
}

/** The name, a link; below it details of the job. @param {ListedJob} job */
function nameOf({ id, name, gear, tags, part_number: part, serial_number: serial }) {
  const gearText = gearInShort(gear);
  const tagged = Object.keys(tags).length > 0;
  const numbers = [shows("part") && part, shows("serial") && serial].filter(Boolean).join(" · ");
  const link = html`<a href=${href("/jobs/{job_id}", { job_id: id })} title=${name} translate="no">${name}</a>`;
  if (compact.value) return link;
  return html`${link}
    ${numbers && html`<span class="job-numbers" translate="no">${numbers}</span>`}
    ${(gearText || tagged) && html`<span class="job-more" translate="no">${gearText && html`<span>${gearText}</span>`}${tagged && h(Tags, { tags })}</span>`}`;
}

/** @param {string | null | undefined} value */
function data(value) {
  return value ? html`<span translate="no">${value}</span>` : ABSENT;
}

/** @param {Record<string, string>} tags */
const tagText = (tags) =>
  Object.entries(tags)
    .map(([name, value]) => `${name}=${value}`)
    .join("; ");

/** The status, and that of each flank if they differ. @param {ListedJob} job */
function statusOf({ status, left_status: left, right_status: right }) {
  const badge = (/** @type {ListedJob["status"]} */ one) => h(Badge, { kind: KINDS[one], children: t[one] });
  if (!left || !right || left === right) return badge(status);
  return html`<span class="flank-statuses">${t.left} ${badge(left)} ${t.right} ${badge(right)}</span>`;
}
