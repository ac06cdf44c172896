// Filters of the list of jobs, and the counts of matching jobs.

import assert from "node:assert/strict";
import { test } from "node:test";
import { countOf, countsByStatus, filtersOf, isReversed, listQuery, sortOf } from "../../app/jobs/filters.js";

const address = (/** @type {string} */ text) => new URLSearchParams(text);

test("the address names filters, and the request has those that say something", () => {
  const filters = filtersOf(address("q=+sun+&status=open&machine=&part=4711&other=1&sort=name&cursor=abc"));
  assert.deepEqual(filters, { q: " sun ", status: "open", part: "4711" });
  assert.equal(sortOf(address("sort=name")), "name");
  assert.equal(sortOf(address("sort=nonsense")), "changed");
  assert.deepEqual(listQuery(filters, "name", "abc"), {
    limit: 50,
    sort: "name",
    q: "sun",
    status: "open",
    part_number: "4711",
    cursor: "abc",
  });
});

test("days are whole days of this place", () => {
  const query = listQuery({ from: "2026-03-28", to: "2026-03-29" }, "changed", undefined);
  assert.equal(query.from, new Date(2026, 2, 28).toISOString());
  // the last day too, however many hours it has
  assert.equal(query.to, new Date(2026, 2, 30).toISOString());
  assert.ok(!("from" in listQuery({ from: "yesterday" }, "changed", undefined)));
  assert.ok(isReversed({ from: "2026-03-02", to: "2026-03-01" }));
  assert.ok(!isReversed({ from: "2026-03-01", to: "2026-03-01" }) && !isReversed({ to: "2026-03-01" }));
});

test("counts by status follow the filters, or are unknown", () => {
  /** @type {any} */
  const summary = { total: 208, by_status: [{ status: "open", count: 129 }] };
  const all = countsByStatus({ status: "open" }, summary, undefined);
  assert.deepEqual([all(undefined), all("open")], [208, 129]);
  /** @type {{ items: { status: "open" | "new" }[] }} */
  const found = { items: [{ status: "open" }, { status: "open" }, { status: "new" }] };
  const some = countsByStatus({ machine: "KX 300 P" }, summary, found);
  assert.deepEqual([some(undefined), some("open"), some("new"), some("rejected")], [3, 2, 1, 0]);
  const more = countsByStatus({ machine: "KX 300 P" }, summary, { ...found, next_cursor: "abc" });
  assert.deepEqual([more(undefined), more("open")], [undefined, undefined]);
  assert.equal(countsByStatus({ q: "sun" }, summary, undefined)("open"), undefined);
});

test("a count is shown if it is known", () => {
  /** @type {import("../../app/jobs/filters.js").JobSummary} */
  const summary = {
    total: 120,
    by_status: [{ status: "open", count: 70 }],
    by_machine: [{ machine: "grinder 3", count: 51 }],
    without_machine: 0,
    by_week: [],
    earlier: 0,
  };
  const list = { page: 1, shown: 50, more: true };
  assert.equal(countOf({}, summary, list), 120);
  assert.equal(countOf({ status: "open" }, summary, list), 70);
  assert.equal(countOf({ machine: "grinder 3" }, summary, list), 51);
  assert.equal(countOf({ machine: "grinder 3", status: "open" }, summary, list), undefined);
  assert.equal(countOf({ q: "sun" }, summary, list), undefined);
  assert.equal(countOf({ q: "sun" }, summary, { page: 2, shown: 7, more: false }), 57);
  assert.equal(countOf({}, undefined, { page: undefined, shown: 7, more: false }), undefined);
});
