import assert from "node:assert/strict";
import { test } from "node:test";
import { batlow, vik } from "../../app/lib/colour_maps.js";
import {
  amountColour,
  css,
  deviationColour,
  niceAbove,
  OKABE_ITO,
  SERIES,
  stepsBetween,
  symmetricLimit,
} from "../../app/lib/colour.js";
import { ciede2000, seenBy } from "./ciede2000.js";

/** @typedef {import("../../app/lib/colour_maps.js").Rgb} Rgb */

test("the measure of difference gives the published values", () => {
  // Sharma, Wu, Dalal (2005), table 1: pairs 1, 7, 13, 17, 25
  /** @type {[[number, number, number], [number, number, number], number][]} */
  const pairs = [
    [[50, 2.6772, -79.7751], [50, 0, -82.7485], 2.0425],
    [[50, 0, 0], [50, -1, 2], 2.3669],
    [[50, 2.5, 0], [50, 0, -2.5], 4.3065],
    [[50, 2.5, 0], [73, 25, -18], 27.1492],
    [[60.2574, -34.0099, 36.2677], [60.4626, -34.1751, 39.4387], 1.2644],
  ];
  for (const [one, other, difference] of pairs) assert.ok(Math.abs(ciede2000(one, other) - difference) < 5e-5);
});

for (const [name, map] of /** @type {const} */ ([
  ["vik", vik],
  ["batlow", batlow],
])) {
  test(`neighbouring steps of ${name} differ evenly`, () => {
    const steps = Array.from(
      { length: 32 },
      (_, i) => /** @type {Rgb} */ (map[Math.round((i * (map.length - 1)) / 31)]),
    );
    const lab = steps.map((step) => seenBy("everybody", step));
    const differences = lab.slice(1).map((one, i) => ciede2000(one, /** @type {typeof one} */ (lab[i])));
    const mean = differences.reduce((sum, one) => sum + one, 0) / differences.length;
    for (const difference of differences) {
      assert.ok(difference >= 0.5 * mean && difference <= 2 * mean, `${difference} with a mean of ${mean}`);
    }
  });

  test(`the ends of ${name} are distinguishable without red or green cones`, () => {
    for (const eye of /** @type {const} */ (["everybody", "protan", "deutan"])) {
      const [first, last] = [map[0], map.at(-1)].map((one) => seenBy(eye, /** @type {Rgb} */ (one)));
      const difference = ciede2000(
        /** @type {NonNullable<typeof first>} */ (first),
        /** @type {NonNullable<typeof last>} */ (last),
      );
      assert.ok(difference >= 40, `${eye}: ${difference}`);
    }
  });
}

test("deviations are symmetric about 0, and clamped at the limit", () => {
  assert.deepEqual(deviationColour(-5, 5), vik[0]);
  assert.deepEqual(deviationColour(9, 5), vik.at(-1));
  assert.deepEqual(deviationColour(0, 5), vik[104]);
  assert.deepEqual(deviationColour(1, 0), vik[104], "where all is 0");
  assert.deepEqual(amountColour(1, [1, 2]), batlow[0]);
  assert.deepEqual(amountColour(2, [1, 2]), batlow[255]);
  assert.equal(css([1, 2, 3]), "rgb(1 2 3)");
});

test("limits are steps of a decade, and only far outliers are clipped", () => {
  assert.deepEqual(
    [0.9, 1, 1.1, 1.6, 2.1, 3.2, 4.1, 5.01, 6.3, 8.2, 0.013, 12.2, 13.5].map(niceAbove),
    [1, 1, 1.5, 2, 3, 4, 5, 6, 8, 10, 0.015, 15, 15],
  );
  assert.equal(niceAbove(0), 1);
  assert.deepEqual(stepsBetween(0.9, 5), [1, 1.5, 2, 3, 4, 5]);
  const values = Array.from({ length: 100 }, (_, i) => (i % 2 ? 1 : -1) * i * 0.01);
  assert.deepEqual(symmetricLimit(values), { limit: 1, clipped: 0 });
  assert.deepEqual(
    symmetricLimit([...values, 1.8, null, Number.NaN]),
    { limit: 2, clipped: 0 },
    "the greatest is seen",
  );
  assert.deepEqual(symmetricLimit([...values, 40, null, Number.NaN]), { limit: 1, clipped: 1 }, "a gross error");
  assert.deepEqual(symmetricLimit([]), { limit: 1, clipped: 0 });
});

test("a symmetric scale holds all values, or at least 99 % of any", () => {
  for (let seed = 1; seed <= 300; seed += 1) {
    let state = seed;
    const random = () => {
      state = (state * 48271) % 2147483647;
      return state / 2147483647;
    };
    // from all alike to nine powers of ten
    const values = Float64Array.from(
      { length: 1 + (seed % 297) },
      () => (random() - 0.5) * 10 ** ((seed % 10) * random()),
    );
    const sizes = [...values].map(Math.abs).sort((a, b) => a - b);
    const { limit, clipped } = symmetricLimit(values);
    assert.equal(clipped, sizes.filter((size) => size > limit).length);
    assert.ok(clipped <= 0.01 * sizes.length, `${clipped} of ${sizes.length}`);
    const percentile = sizes[Math.ceil(0.99 * sizes.length) - 1] ?? 0;
    assert.equal(limit, niceAbove((clipped > 0 ? percentile : sizes.at(-1)) ?? 0));
    if (clipped > 0) assert.ok(niceAbove(sizes.at(-1) ?? 0) > 2 * limit, `${sizes.at(-1)} clipped at ${limit}`);
  }
});

test("series are all there", () => {
  assert.deepEqual([...SERIES].sort(), Object.keys(OKABE_ITO).sort());
});
