// Nodes as CSV, for the page of a fit and for that of measurements alike.

import assert from "node:assert/strict";
import { test } from "node:test";
import { headerOf, readNodesCsv } from "../../app/lib/nodes_csv.js";
import { readNodes } from "../../app/lib/nodes_file.js";
import { readFile } from "../../app/measure/read.js";

/** What people's programs write: a mark of the byte order, quotes, old line ends, blank lines. */
const TABLES = [
  "u,v,z\n1,1,2\n1,2,3\n2,1,\n2,2,4\n",
  '\uFEFF"u","v","z","weight"\r\n"1", 2 ,3.5,1\r\n\r\n2,2,,1\r\n',
  "x,y\r0,1\r1,abc\r2,\r",
  "u,v,z\n1,1\n1,2,-4e-1\n",
  "\n\nx,y\n1,2\n",
];

test("both pages read the same nodes of a table", () => {
  for (const text of TABLES) {
    const table = readNodesCsv(text);
    const ofFit = readNodes(text).file;
    const ofMeasurement = readFile("a.csv", new TextEncoder().encode(text));
    assert.ok(table && ofFit, text);
    assert.deepEqual([ofFit.count, ofFit.missing], [table.count, table.missing], text);
    assert.deepEqual([ofMeasurement.nodes, ofMeasurement.missing], [table.count, table.missing], text);
  }
});

test("cells that are no numbers are named by line and column as the file counts", () => {
  const table = readNodesCsv("\nu,v,z,weight\n1,x,,\n\n,2,NaN,1\n");
  assert.deepEqual(table?.doubts, [
    { line: 3, column: 2, found: "x" },
    { line: 5, column: 1, found: "" },
    { line: 5, column: 3, found: "NaN" },
  ]);
  assert.deepEqual([table?.count, table?.missing], [2, 2]);
});

test("another header is none, and can be said", () => {
  for (const text of ["a;b\n1;2", "U,V,Z\n1,1,1", "u,v,z,w\n1,1,1,1", ""]) assert.equal(readNodesCsv(text), undefined);
  assert.equal(headerOf('\uFEFF"a" , b\n1,2'), "a,b");
});
