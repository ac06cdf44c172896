import assert from "node:assert/strict";
import { test } from "node:test";
import { csv } from "../../app/lib/csv.js";

/** @param {string | number | boolean | null | undefined} value */
const one = (value) =>
  csv([{ header: "x", value: () => value }], [0])
    .split("\r\n")
    .slice(1, -1)
    .join("\r\n");

test("lines end as RFC 4180 has them, units are in the header", () => {
  const columns = [
    { header: "slope", unit: "µm", value: (/** @type {number[]} */ row) => row[0] },
    { header: "a, b", value: (/** @type {number[]} */ row) => row[1] },
  ];
  assert.equal(csv(columns, [[0.1 + 0.2, -1e-9]]), 'slope [µm],"a, b"\r\n0.3,-1e-9\r\n');
  assert.equal(csv(columns, []), 'slope [µm],"a, b"\r\n');
});

test("quotes, absent values and what is no number", () => {
  assert.equal(one('a "b", c'), '"a ""b"", c"');
  assert.equal(one("two\nlines"), '"two\nlines"');
  for (const value of [undefined, null, Number.NaN, Number.POSITIVE_INFINITY, ""]) assert.equal(one(value), "");
  assert.equal(one(true), "true");
});

test("text that a spreadsheet would compute is none any more; numbers stay", () => {
  for (const start of ["=", "+", "-", "@"]) assert.equal(one(`${start}1`), `'${start}1`);
  assert.equal(one("=HYPERLINK(1,2)"), `"'=HYPERLINK(1,2)"`);
  assert.equal(one(-1), "-1");
  assert.equal(one("a=1"), "a=1");
});

test("in German as its spreadsheets read it: semicolons, decimal commas, UTF-8 that says so", () => {
  const columns = [
    { header: "Höhen\u00adballigkeit", unit: "µm", value: (/** @type {any} */ row) => row[0] },
    { header: "innerhalb", value: (/** @type {any} */ row) => row[1] },
    { header: "Grenzen", value: (/** @type {any} */ row) => row[2] },
  ];
  const rows = [
    [3.674999999999997, true, [-7.5, 7.5]],
    [-1234.5, false, undefined],
    [null, undefined, "a; b"],
  ];
  assert.equal(
    csv(columns, rows, "de"),
    '\uFEFFHöhenballigkeit [µm];innerhalb;Grenzen\r\n3,675;ja;-7,5 … 7,5\r\n-1234,5;nein;\r\n;;"a; b"\r\n',
  );
});
