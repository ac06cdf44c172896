// Nodes as CSV, for the page of a fit and for that of measurements alike.

import assert from "node:assert/strict";
import { test } from "node:test";
import { gridOfTable, headerOf, readNodesCsv } from "../../app/lib/nodes_csv.js";
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

/** @param {string} text */
function gridOf(text) {
  const table = readNodesCsv(text);
  assert.ok(table, text);
  return gridOfTable(table);
}

test("a table whose nodes stand on crossings is a grid, whatever their order", () => {
  const places = [3, 1, 2].flatMap((u) => [10, 30, 20].map((v) => /** @type {const} */ ([u, v])));
  const rows = places.map(([u, v]) => `${u},${v},${u + v}`);
  const whole = {
    type: "grid",
    u: [1, 2, 3],
    v: [10, 20, 30],
    z: [1, 2, 3].map((u) => [10, 20, 30].map((v) => u + v)),
  };
  assert.deepEqual(gridOf(["u,v,z", ...rows].join("\n")), whole);
  // a missing height, and a missing line
  const holes = gridOf(["u,v,z", ...rows.slice(1, -1), "2,20,"].join("\n"));
  assert.deepEqual(holes?.z, [
    [11, 21, 31],
    [12, null, 32],
    [null, 23, 33],
  ]);
  const weighted = gridOf("u,v,z,weight\n1,1,1,2\n1,2,1,0\n2,1,1,1\n2,2,1,3\n");
  assert.deepEqual(weighted?.weight, [
    [2, 0],
    [1, 3],
  ]);
});

test("scattered nodes, nodes that stand twice and curves are no grid", () => {
  assert.equal(gridOf("u,v,z\n1,1,1\n1,1,2\n1,2,1\n2,1,1\n2,2,1\n"), undefined, "twice");
  assert.equal(gridOf("u,v,z\n1,1.1,1\n2,1.2,2\n3,1.3,1\n4,1.4,1\n"), undefined, "scattered");
  assert.equal(gridOf("u,v,z\n1,1,1\n1,2,2\n1,3,1\n"), undefined, "one line");
  assert.equal(gridOf("x,y\n1,1\n1,2\n"), undefined, "a curve");
});

test("both pages send a grid as a grid, and a doubtful table as it is", () => {
  const text = "u,v,z\n1,1,2\n1,2,3\n2,1,\n2,2,4\n";
  const grid = {
    type: "grid",
    u: [1, 2],
    v: [1, 2],
    z: [
      [2, 3],
      [null, 4],
    ],
  };
  const ofFit = readNodes(text).file;
  assert.deepEqual([ofFit?.kind, ofFit?.nodes], ["json", grid]);
  const ofMeasurement = readFile("a.csv", new TextEncoder().encode(text));
  assert.deepEqual([ofMeasurement.kind, ofMeasurement.request], ["json", { nodes: grid }]);
  const doubtful = text.replace("3", "three");
  assert.equal(readNodes(doubtful).file?.kind, "csv");
  assert.equal(readFile("a.csv", new TextEncoder().encode(doubtful)).kind, "csv");
});
