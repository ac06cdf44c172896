// Filters of the list of jobs: in the address, in requests, and the number of matching jobs if it
// is known. Pure.

/** @typedef {import("../api/client.js").Schema<"JobSummary">} JobSummary */
/** @typedef {import("../api/client.js").Schema<"JobStatus">} JobStatus */
/** @typedef {NonNullable<NonNullable<import("../api/client.js").Paths["/v1/jobs"]["get"]["parameters"]["query"]>["sort"]>} Sort */
/**
 * Filters as in the address: dates without times, in local time.
 * @typedef {{ q?: string, status?: string, machine?: string, part?: string, tag?: string, class?: string, from?: string, to?: string }} Filters
 */

export const ON_A_PAGE = 50;
/** @satisfies {readonly JobStatus[]} */
export const STATUSES = /** @type {const} */ (["new", "open", "remachine", "accepted", "rejected"]);
/** @satisfies {readonly Sort[]} */
export const SORTS = /** @type {const} */ (["changed", "name", "created"]);
const NAMES = /** @type {const} */ (["q", "status", "machine", "part", "tag", "class", "from", "to"]);

/** @param {URLSearchParams} address @returns {Filters} */
export function filtersOf(address) {
  return Object.fromEntries(NAMES.flatMap((name) => (address.get(name) ? [[name, address.get(name)]] : [])));
}

/** No filter, and the first page. */
export const noFilters = () => ({ ...Object.fromEntries(NAMES.map((name) => [name, undefined])), ...firstPage });
export const firstPage = { cursor: undefined, page: undefined };

/** @param {URLSearchParams} address @returns {Sort} */
export function sortOf(address) {
  return SORTS.find((one) => one === address.get("sort")) ?? "changed";
}

/**
 * Returns the query of `GET /v1/jobs`. Invalid values of the address are sent unchanged, so that
 * the server reports them.
 * @param {Filters} filters @param {Sort} sort @param {string | undefined} cursor
 */
export function listQuery({ q, status, machine, part, tag, class: of, from, to }, sort, cursor) {
  const begins = midnight(from, 0);
  const ends = midnight(to, 1);
  return {
    limit: ON_A_PAGE,
    sort,
    ...(q?.trim() ? { q: q.trim() } : {}),
    ...(status ? { status: /** @type {JobStatus} */ (status) } : {}),
    ...(machine ? { machine } : {}),
    ...(part ? { part_number: part } : {}),
    ...(tag ? { tag } : {}),
    ...(of ? { class: /** @type {number} */ (/** @type {unknown} */ (of)) } : {}),
    ...(begins ? { from: begins } : {}),
    ...(ends ? { to: ends } : {}),
    ...(cursor ? { cursor } : {}),
  };
}

/** Returns the local midnight that begins a day, or one of the days after it. @param {string | undefined} day @param {number} later */
function midnight(day, later) {
  const [, year, month, date] = /^(\d{4})-(\d\d)-(\d\d)$/.exec(day ?? "") ?? [];
  if (!year || !month || !date) return undefined;
  return new Date(Number(year), Number(month) - 1, Number(date) + later).toISOString();
}

/** Returns true if the last day is before the first. @param {{ from?: string, to?: string }} days */
export const isReversed = ({ from, to }) => Boolean(from && to && to < from);

/**
 * Returns the number of jobs of each status, and of all, that match the other filters; undefined if it is not known.
 * @param {Filters} filters @param {JobSummary | undefined} summary
 * @param {{ items: readonly { status: JobStatus }[], next_cursor?: string | null | undefined } | undefined} found jobs of any status
 * @returns {((status: JobStatus | undefined) => number | undefined)}
 */
export function countsByStatus({ status: _, ...others }, summary, found) {
  if (Object.keys(others).length === 0)
    return (status) => (status ? summary?.by_status.find((one) => one.status === status)?.count : summary?.total);
  if (!found || found.next_cursor) return () => undefined;
  return (status) => found.items.filter((one) => status === undefined || one.status === status).length;
}

/**
 * Returns the number of matching jobs, if the counts have it or all of them are on this page.
 * @param {Filters} filters @param {JobSummary | undefined} summary
 * @param {{ page: number | undefined, shown: number, more: boolean }} list
 */
export function countOf(filters, summary, { page, shown, more }) {
  const [first, ...others] = /** @type {[keyof Filters, string][]} */ (Object.entries(filters));
  if (!more && page !== undefined) return (page - 1) * ON_A_PAGE + shown;
  if (!summary || others.length > 0) return undefined;
  if (!first) return summary.total;
  const [name, value] = first;
  if (name === "status") return summary.by_status.find(({ status }) => status === value)?.count;
  if (name === "machine") return summary.by_machine.find(({ machine }) => machine === value)?.count;
  return undefined;
}
