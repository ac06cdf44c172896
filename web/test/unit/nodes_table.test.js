// The interpretation of a table, and its changes.

import assert from "node:assert/strict";
import { test } from "node:test";
import { mappingOf, namesAxes, withColumn } from "../../app/lib/nodes_table.js";
import { proposed, readFile } from "../../app/measure/read.js";
import { EMPTY, answered, specOf } from "../../app/measure/request.js";

const PROPOSAL = /** @type {import("../../app/lib/nodes_table.js").Proposal} */ (
  /** @type {unknown} */ ({
    separator: ";",
    decimal: ",",
    header: true,
    matrix: false,
    columns: [
      { name: "Rollweg [mm]", meaning: "roll_length", unit: "mm" },
      { name: "Breite", meaning: "face_width", unit: "mm" },
      { name: "Abw", meaning: "deviation", unit: "um" },
    ],
    layout: "grid",
    nodes: 3,
    missing: 1,
    axes: {
      u: { quantity: "roll_length", unit: "mm" },
      v: { quantity: "face_width", unit: "mm" },
      z: { quantity: "deviation", unit: "um", positive: "material_out" },
    },
    preview: { text: "", ranges: [] },
    warnings: [],
    read: {
      type: "grid",
      u: [1, 2],
      v: [1, 2],
      z: [
        [1, 2],
        [null, 4],
      ],
    },
  })
);

const table = readFile("left.csv", new TextEncoder().encode("Rollweg [mm];Breite;Abw\n1;1;1\n"));

test("a table is read by the server, and drawn from its answer", () => {
  assert.equal(table.kind, "table");
  const content = proposed(table, PROPOSAL);
  assert.deepEqual([content.kind, content.form, content.nodes, content.missing], ["table", "grid", 4, 1]);
  assert.deepEqual([...(content.surface?.z ?? [])], [1, 2, Number.NaN, 4]);
  // its columns define the axes
  const typed = answered(EMPTY, content, { name: "left.csv", gear: undefined });
  assert.deepEqual([typed.axes, typed.flank], ["", "left"]);
  assert.ok(!("axes" in specOf(typed, content)));
  const { axes: _, ...plain } = PROPOSAL;
  const other = proposed(table, plain);
  assert.equal(answered(EMPTY, other, { name: "left.csv", gear: undefined }).axes, "none");
  const { layout: __, read: ___, ...unknown } = PROPOSAL;
  assert.equal(proposed(table, unknown).failure, "columns");
  const points = proposed(table, { ...unknown, layout: "points" });
  assert.deepEqual([points.kind, points.form, points.failure], ["import", "points", undefined]);
  assert.deepEqual([namesAxes(PROPOSAL), namesAxes(plain), namesAxes(undefined)], [true, false, false]);
});

test("a changed column keeps its unit where it can, and takes its meaning from others", () => {
  const mapping = mappingOf(PROPOSAL);
  assert.deepEqual(Object.keys(mapping), ["separator", "decimal", "header", "matrix", "columns"]);
  const units = (/** @type {import("../../app/lib/nodes_table.js").Mapping} */ { columns }) =>
    (columns ?? []).map(({ meaning, unit }) => [meaning, unit]);
  assert.deepEqual(units(withColumn(mapping, 2, { unit: "mm" }))[2], ["deviation", "mm"]);
  assert.deepEqual(units(withColumn(mapping, 0, { meaning: "diameter" }))[0], ["diameter", "mm"]);
  assert.deepEqual(units(withColumn(mapping, 0, { meaning: "roll_angle" }))[0], ["roll_angle", "deg"]);
  assert.deepEqual(units(withColumn(mapping, 1, { meaning: "deviation" })), [
    ["roll_length", "mm"],
    ["deviation", "mm"],
    ["ignore", undefined],
  ]);
});
