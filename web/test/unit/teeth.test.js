// Deviations of several teeth, separated into flanks.

import assert from "node:assert/strict";
import { test } from "node:test";
import { sectionOf } from "../../app/flank/surface.js";
import { commonRange, flanksOf, inFigures } from "../../app/flank/teeth.js";

/** @typedef {import("../../app/flank/teeth.js").GearDeviations} GearDeviations */

/** @param {[number, "left" | "right", number | null, number | null, number | null][]} points tooth, flank, roll length, z, deviation */
const answered = (points) =>
  /** @type {GearDeviations} */ (
    /** @type {unknown} */ ({
      tooth: points.map(([tooth]) => tooth),
      flank: points.map(([, flank]) => flank),
      roll_length_mm: points.map(([, , u]) => u),
      z_mm: points.map(([, , , v]) => v),
      deviation_um: points.map(([, , , , z]) => z),
    })
  );

test("points are parted by tooth and flank, left ones first; those without a place belong nowhere", () => {
  const flanks = flanksOf([
    answered([
      [3, "right", 1, 0, 5],
      [3, "right", 2, 0, 6],
      [3, "right", 1, 9, 7],
      [3, "right", 2, 9, null],
      [12, "left", 1, 0, -1],
      [12, "left", 2, 0, -2],
      [12, "left", 1, 9, -3],
      [12, "left", 2, 9, -6],
      [0, "left", null, null, null],
      [12, "left", null, 3, null],
    ]),
  ]);
  assert.deepEqual(
    flanks.map(({ key }) => key),
    ["12-left", "3-right"],
  );
  const [left, right] = flanks;
  assert.ok(left && right);
  assert.equal(left.surface.kind, "grid");
  assert.deepEqual(inFigures(left), { count: 4, least: -6, greatest: -1, mean: -3, rms: Math.sqrt(50 / 4) });
  assert.deepEqual(inFigures(right), { count: 3, least: 5, greatest: 7, mean: 6, rms: Math.sqrt(110 / 3) });
  assert.deepEqual(sectionOf(left.surface, "profile", 9), [
    { x: 1, y: -3 },
    { x: 2, y: -6 },
  ]);
  assert.deepEqual(
    [commonRange(flanks, "u"), commonRange(flanks, "v")],
    [
      [1, 2],
      [0, 9],
    ],
  );
});

test("of several results for a flank the last one counts, unless it is empty", () => {
  const grid = (/** @type {number | null} */ z) =>
    answered([
      [1, "left", 1, 0, z],
      [1, "left", 2, 0, z],
      [1, "left", 1, 9, z],
      [1, "left", 2, 9, z],
    ]);
  const only = (/** @type {GearDeviations[]} */ answers) => flanksOf(answers).map((of) => inFigures(of).mean);
  assert.deepEqual(only([grid(1), grid(4)]), [4]);
  assert.deepEqual(only([grid(1), grid(null)]), [1]);
  assert.deepEqual(only([grid(null)]), []);
});

test("points on no grid are triangles, in which a plane is a plane", () => {
  const places = Array.from({ length: 40 }, (_, i) => [Math.sin(37 * i) + 2, 5 * Math.cos(11 * i) + 5]);
  const [flank] = flanksOf([answered(places.map(([u = 0, v = 0]) => [7, "left", u, v, 2 * u - v]))]);
  assert.equal(flank?.surface.kind, "scattered");
  for (const { x, y } of sectionOf(/** @type {NonNullable<typeof flank>} */ (flank).surface, "profile", 5))
    if (Number.isFinite(y)) assert.ok(Math.abs(y - (2 * x - 5)) < 1e-9, `${x} ${y}`);
});
