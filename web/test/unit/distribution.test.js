import assert from "node:assert/strict";
import { test } from "node:test";
import { histogram, MOST_POINTS, normalQuantile, placeOfNode, thinned } from "../../app/statistics/distribution.js";

test("normal quantiles", () => {
  for (const [p, x] of /** @type {const} */ ([
    [0.5, 0],
    [0.975, 1.959963984540054],
    [0.025, -1.959963984540054],
    [0.01, -2.3263478740408408],
    [0.9999, 3.719016485455709],
  ]))
    assert.ok(Math.abs(normalQuantile(p) - x) < 1e-8, String(p));
});

test("a histogram counts every value once", () => {
  const values = Array.from({ length: 500 }, (_, i) => normalQuantile((i + 0.5) / 500));
  const bins = histogram(values);
  assert.equal(
    bins.reduce((sum, { count }) => sum + count, 0),
    500,
  );
  assert.deepEqual(histogram([2, 2]), [{ from: 1.5, to: 2.5, count: 2 }]);
  assert.deepEqual(histogram([]), []);
});

test("many points are thinned evenly, first and last kept", () => {
  const many = Array.from({ length: 100_000 }, (_, i) => i);
  const few = thinned(many);
  assert.deepEqual([few.length, few[0], few.at(-1)], [MOST_POINTS, 0, 99_999]);
});

test("nodes of a grid lie row by row", () => {
  const nodes = { type: /** @type {const} */ ("grid"), u: [1, 2], v: [5, 6, 7], z: [] };
  assert.deepEqual(placeOfNode(nodes, 4), { u: 2, v: 6 });
});
