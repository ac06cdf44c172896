// Grids and scattered nodes as surfaces: sections, images, contours.

import assert from "node:assert/strict";
import { test } from "node:test";
import { contoursOf, levelsOf } from "../../app/flank/contours.js";
import { atAllNodes, atNodes } from "../../app/flank/layers.js";
import { heightsOf, imageOf, placeOf, toX, toY } from "../../app/flank/raster.js";
import {
  boxOf,
  countsOf,
  difference,
  extremesOf,
  gridOf,
  heightAt,
  nearestNode,
  sectionOf,
} from "../../app/flank/surface.js";
import { scatteredOf } from "../../app/flank/triangles.js";

/** z = u + 10 v at 3 × 4 places, of which one is missing. */
const grid = gridOf(
  [1, 2, 4],
  [0, 1, 2, 3],
  [
    [1, 11, 21, 31],
    [2, 12, null, 32],
    [4, 14, 24, 34],
  ],
);

test("a grid has its box, its counts and its extremes by row and column", () => {
  assert.deepEqual(boxOf(grid), { u: [1, 4], v: [0, 3] });
  assert.deepEqual(countsOf(grid), { nodes: 12, missing: 1 });
  assert.deepEqual(extremesOf(grid)?.least, { index: 0, u: 1, v: 0, z: 1, row: 0, column: 0 });
  assert.deepEqual(extremesOf(grid)?.greatest, { index: 11, u: 4, v: 3, z: 34, row: 2, column: 3 });
  assert.equal(extremesOf(gridOf([1], [1], [[null]])), undefined);
});

test("heights between nodes are bilinear; missing nodes leave a gap of half a cell", () => {
  const exact = (/** @type {number} */ u, /** @type {number} */ v) =>
    assert.ok(Math.abs(heightAt(grid, u, v) - (u + 10 * v)) < 1e-12, `${u}, ${v}: ${heightAt(grid, u, v)}`);
  for (const [u, v] of /** @type {const} */ ([
    [1, 0],
    [4, 3],
    [1.25, 0.75],
    [3, 0.5],
    [2, 1],
    [1, 2],
    [1.1, 1.5],
    [3.9, 1.5],
    [1.2, 2.5],
    [3.5, 2.9],
  ]))
    exact(u, v);
  assert.ok(Number.isNaN(heightAt(grid, 2, 2)));
  assert.ok(Number.isNaN(heightAt(grid, 2.1, 2.1)));
  assert.ok(Number.isNaN(heightAt(grid, 0.9, 1)));
});

test("sections go through the nodes; a missing one is a gap", () => {
  assert.deepEqual(sectionOf(grid, "profile", 1), [
    { x: 1, y: 11 },
    { x: 2, y: 12 },
    { x: 4, y: 14 },
  ]);
  assert.deepEqual(
    sectionOf(grid, "helix", 2).map(({ y }) => y),
    [2, 12, Number.NaN, 32],
  );
});

test("the nearest node, and the difference of two surfaces", () => {
  assert.equal(nearestNode(grid, 2.9, 1.6).index, 6);
  assert.equal(nearestNode(grid, 99, -5).index, 8);
  const { surface, exact } = difference(grid, grid);
  assert.ok(exact);
  assert.equal(surface.z[5], 0);
  const coarse = gridOf(
    [1, 4],
    [0, 3],
    [
      [1, 31],
      [4, 34],
    ],
  );
  const between = difference(grid, coarse);
  assert.ok(!between.exact);
  assert.ok(between.surface.z.every((z, i) => (i === 6 ? Number.isNaN(z) : Math.abs(z) < 1e-12)));
});

test("scattered nodes of a plane are that plane between them, wherever triangles lie", () => {
  const places = Array.from({ length: 300 }, (_, i) => [(i * 0.618034) % 1, (i * 0.414214 + 0.1) % 1]);
  const plane = (/** @type {number} */ u, /** @type {number} */ v) => 3 - 2 * u + 0.02 * v;
  const surface = scatteredOf(
    places.map(([u = 0]) => u),
    places.map(([, v = 0]) => 100 * v),
    places.map(([u = 0, v = 0]) => plane(u, 100 * v)),
  );
  assert.ok(Math.abs(heightAt(surface, 0.4, 55) - plane(0.4, 55)) < 1e-9);
  const profile = sectionOf(surface, "profile", 50);
  assert.ok(profile.length > 10);
  for (const { x, y } of profile) assert.ok(Math.abs(y - plane(x, 50)) < 1e-9);
  const view = { width: 60, height: 40, box: boxOf(surface) };
  const heights = heightsOf(surface, view);
  const seen = heights.filter((height) => Number.isFinite(height));
  assert.ok(seen.length > 0.9 * heights.length);
  const { u, v } = placeOf(view, 30.5, 20.5);
  assert.ok(Math.abs((heights[20 * 60 + 30] ?? 0) - plane(u, v)) < 1e-5);
});

test("an image has the root below and the toe left, missing hatched, outside clear", () => {
  const view = { width: 30, height: 30, box: { u: /** @type {const} */ ([1, 4]), v: /** @type {const} */ ([0, 6]) } };
  const heights = heightsOf(grid, view);
  assert.ok((heights[29 * 30] ?? 0) < 4, "least below left");
  assert.ok((heights[14] ?? 0) > 30, "greatest above at the middle");
  assert.equal(heights[29], Number.POSITIVE_INFINITY);
  assert.equal(toX(view, 3), 15);
  assert.equal(toY(view, 4), 0);
  assert.equal(toY({ ...view, flipU: true }, 4), 30);
  const image = imageOf(heights, 30, 50);
  const pixel = (/** @type {number} */ i) => [...image.slice(4 * i, 4 * i + 4)];
  assert.deepEqual(pixel(29), [0, 0, 0, 0]);
  assert.equal(pixel(0)[3], 255);
  const [red = 0, , blue = 0] = pixel(14);
  assert.ok(red > blue, "excess material is red");
  const [low = 0, , high = 0] = [...imageOf(Float32Array.of(-1), 1, 1)];
  assert.ok(high > low, "what is missing is blue");
});

test("contours of a plane lie on it; a saddle has two lines", () => {
  const width = 5;
  const heights = Float32Array.from({ length: 25 }, (_, i) => (i % width) + 0.5 * Math.floor(i / width));
  const [line] = contoursOf(heights, width, [2.25]);
  assert.ok(line);
  for (const [x, y, p, q] of line.segments) {
    assert.ok(Math.abs(x + 0.5 * y - 2.25) < 1e-6);
    assert.ok(Math.abs(p + 0.5 * q - 2.25) < 1e-6);
  }
  assert.equal(contoursOf([1, -1, -1, 1], 2, [0.1])[0]?.segments.length, 2);
  assert.deepEqual(contoursOf([1, Number.NaN, -1, 1], 2, [0]), []);
  assert.deepEqual(levelsOf(10), [-10, -8, -6, -4, -2, 0, 2, 4, 6, 8, 10]);
  assert.deepEqual(levelsOf(1.5), [-1.5, -1.2, -0.9, -0.6, -0.3, 0, 0.3, 0.6, 0.9, 1.2, 1.5]);
  assert.deepEqual(
    levelsOf(0.03),
    [-0.03, -0.025, -0.02, -0.015, -0.01, -0.005, 0, 0.005, 0.01, 0.015, 0.02, 0.025, 0.03],
  );
  assert.deepEqual(levelsOf(7), [-7, -5.6, -4.2, -2.8, -1.4, 0, 1.4, 2.8, 4.2, 5.6, 7], "a limit of one's own");
});

test("results of the counted nodes are at their places", () => {
  const residuals = atNodes(grid, [5, 6], [1, 11]);
  assert.equal(residuals.z[1], 5);
  assert.equal(residuals.z[11], 6);
  assert.ok(Number.isNaN(residuals.z[0]));
  const all = atAllNodes(grid, [1, null, 3, 4, 1, 2, 3, 4, 1, 2, 3, 9]);
  assert.equal(all?.z[11], 9);
  assert.ok(Number.isNaN(all?.z[1]));
  assert.equal(atAllNodes(grid, [1]), undefined);
});
