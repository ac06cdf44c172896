// All jobs: by status, searched, filtered and sorted, 50 a page.

import { answer, api } from "../api/client.js";
import { may } from "../api/key.js";
import { useAtMostEvery, useEventsOfAllJobs } from "../api/live.js";
import { useResource } from "../api/resource.js";
import { Page } from "../components/page.js";
import { Empty, loaded } from "../components/states.js";
import { t as common } from "../i18n/common.js";
import { t } from "../i18n/jobs.js";
import { fmt } from "../i18n/i18n.js";
import { Columns, Density, FilterBar, StatusCounts } from "../jobs/filter_bar.js";
import { countOf, countsByStatus, filtersOf, listQuery, ON_A_PAGE, sortOf } from "../jobs/filters.js";
import { JobList, shows } from "../jobs/list.js";
import { query } from "../navigation.js";
import { href } from "../router.js";
import { h, html, useRef } from "../../vendor/ui.js";

/** @typedef {import("../api/client.js").Schema<"Page_ListedJob">} JobPage */

export const styles = ["jobs"];

/** The delay in ms: a plant may measure more often than anybody reads. */
const LEAST_WAIT = 1000;

export default function Jobs() {
  const filters = filtersOf(query.value);
  const sort = sortOf(query.value);
  const cursor = query.value.get("cursor") ?? undefined;
  const search = listQuery(filters, sort, cursor);
  const list = useResource(`jobs ${JSON.stringify(search)}`, (signal) =>
    answer(api.GET("/v1/jobs", { signal, params: { query: search } })),
  );
  const summary = useResource("jobs summary", (signal) => answer(api.GET("/v1/jobs/summary", { signal })));
  const reread = useAtMostEvery(LEAST_WAIT, () => {
    list.reload();
    summary.reload();
  });
  useEventsOfAllJobs((events) => {
    // a block of a stream changes nothing in the list
    if (events.length === 0 || events.some(({ state }) => state !== "block")) reread();
  });
  // during a search the last list stays, so that nothing jumps
  const last = useRef(/** @type {JobPage | undefined} */ (undefined));
  if (list.data !== undefined) last.current = list.data;
  const shown = list.error === undefined ? { ...list, data: list.data ?? last.current } : list;
  // counts cover all jobs; for a search they are known only if all results are on one page
  const { status, ...others } = filters;
  const narrowed = Object.keys(others).length > 0;
  const every = useResource(
    narrowed && (status || cursor) ? `jobs counted ${JSON.stringify(listQuery(others, "changed", undefined))}` : null,
    (signal) => answer(api.GET("/v1/jobs", { signal, params: { query: listQuery(others, "changed", undefined) } })),
  );
  const counted = status || cursor ? every.data : shown.data;
  const create = may("measure") ? { label: common.newJob, to: href("/jobs/new") } : undefined;
  const none = summary.data?.total === 0 && Object.keys(filters).length === 0 && !cursor;
  return h(Page, {
    title: t.title,
    actions: create && !none && html`<a class="button primary" href=${create.to}>${create.label}</a>`,
    children: none
      ? h(Empty, { children: t.none, action: create, more: html`<a class="button" href="/docs/">${t.interface}</a>` })
      : html`
        <div class="job-filters">
          <div class="job-counts">
            ${h(StatusCounts, { filters, sort, counts: countsByStatus(filters, summary.data, counted) })}<div class="actions">${h(Density, null)}${h(Columns, null)}</div>
          </div>
          ${h(FilterBar, { filters, sort, summary: summary.data, error: list.error })}
        </div>
        ${loaded({
          resource: shown,
          lines: 12,
          children: (data) => h(Listed, { data, filters, sort, cursor, summary: summary.data }),
        })}`,
  });
}

/**
 * @param {{ data: JobPage, filters: import("../jobs/filters.js").Filters, sort: string, cursor: string | undefined,
 *   summary: import("../jobs/filters.js").JobSummary | undefined }} props
 */
function Listed({ data: { items, next_cursor: next }, filters, sort, cursor, summary }) {
  const all = { label: t.allJobs, to: href("/jobs") };
  if (items.length === 0) return h(Empty, { children: cursor ? t.emptyPage : t.noMatch, action: all });
  const page = cursor ? Number(query.value.get("page")) || undefined : 1;
  const count = countOf(filters, summary, { page, shown: items.length, more: Boolean(next) });
  const here = { ...filters, sort: sort === "changed" ? undefined : sort };
  const first = page === undefined ? undefined : (page - 1) * ON_A_PAGE + 1;
  const where = first === undefined ? "" : t.range(fmt.value.count(first), fmt.value.count(first + items.length - 1));
  const tools = html`<p class="list-count" role="status">
      ${where} ${count === undefined ? "" : t.of(fmt.value.count(count))} ${shows("rms") && html`<span class="quiet">${t.rmsUnit}</span>`}
    </p>
    <nav class="actions" aria-label=${t.pages}>
      ${cursor && html`<a class="button small" rel="first" href=${href("/jobs", {}, here)}>${t.firstPage}</a>`}
      ${
        next &&
        html`<a class="button small" rel="next"
          href=${href("/jobs", {}, { ...here, cursor: next, ...(page ? { page: page + 1 } : {}) })}>${t.nextPage}</a>`
      }
    </nav>`;
  return h(JobList, { jobs: items, sort, tools });
}
