import assert from "node:assert/strict";
import { test } from "node:test";
import { excludedBy, excluding, marksOf, suspectsOf } from "../../app/lib/exclude.js";

const warnings = [
  { code: "few_digits", params: { digits: 3 } },
  { code: "outliers_suspected", params: { nodes: [{ index: 46, row: 6, column: 4, off: 77, off_sigmas: 150 }] } },
];

test("suspected and excluded nodes are marks of the map", () => {
  assert.deepEqual(
    suspectsOf(warnings).map(({ index }) => index),
    [46],
  );
  assert.deepEqual(suspectsOf([]), []);
  assert.deepEqual(marksOf(warnings, [3]), [
    { index: 46, kind: "suspected" },
    { index: 3, kind: "excluded" },
  ]);
});

test("a spec leaves nodes out by their cells on a grid, else by their numbers", () => {
  const spec = /** @type {import("../../app/lib/exclude.js").FitSpec} */ ({
    model: { type: "polynomial", degree: [2, 2] },
  });
  const without = excluding(spec, [46, 3, 46], 7);
  assert.deepEqual(without.exclude, [
    { row: 0, column: 3 },
    { row: 6, column: 4 },
  ]);
  assert.deepEqual(excludedBy(without, 7), [3, 46]);
  assert.deepEqual(excluding(spec, [46], undefined).exclude, [46]);
  assert.deepEqual(excluding(without, [], 7), spec);
});
