// The request for the figures of nodes without a job.

import assert from "node:assert/strict";
import { test } from "node:test";
import { flankSurfaceRequest, isSecondOrder } from "../../app/lib/flank_surface.js";

const gear = { teeth: 52, normal_module_mm: 1 };
/** @type {import("../../app/lib/flank_surface.js").Axes} */
const axes = {
  u: { quantity: "roll_length", unit: "mm" },
  v: { quantity: "face_width", unit: "mm" },
  z: { quantity: "deviation", unit: "um" },
};
/** @type {import("../../app/api/client.js").Schema<"Nodes">} */
const grid = {
  type: "grid",
  u: [1, 2],
  v: [3, 4],
  z: [
    [1, null],
    [-2, 3],
  ],
  valid: [
    [true, true],
    [true, false],
  ],
};
const of = { axes, flank: /** @type {const} */ ("left"), gear, spec: {} };

test("a grid in mm and µm goes as it is, without its missing nodes", () => {
  assert.deepEqual(
    flankSurfaceRequest(grid, { ...of, spec: { level: 0.9, model: {}, regularization: { type: "none" } } }),
    {
      level: 0.9,
      regularization: { type: "none" },
      gear,
      flank: "left",
      profile_axis: "roll_length",
      profile: [1, 2],
      z_mm: [3, 4],
      deviation_um: [
        [1, null],
        [-2, null],
      ],
    },
  );
});

test("units are converted: inches, minutes of roll angle, millimetres towards the inside", () => {
  const other = {
    u: { quantity: "roll_length", unit: "arcmin" },
    v: { quantity: "face_width", unit: "in" },
    z: { quantity: "deviation", unit: "mm", positive: /** @type {const} */ ("material_in") },
  };
  const nodes = {
    type: /** @type {const} */ ("scattered"),
    u: [60, 120],
    v: [1, 2],
    z: [0.001, 0.002],
    weight: [1, 0],
  };
  const request = flankSurfaceRequest(nodes, { ...of, axes: other, spec: { noise_sigma: 0.0005 } });
  assert.deepEqual(
    [request?.profile_axis, request?.profile, request?.z_mm, request?.deviation_um, request?.noise_sigma],
    ["roll_angle", [1, 2], [25.4, 50.8], [-1, null], 0.5],
  );
});

test("no request without axes of a flank, or for a fit that the surface cannot follow", () => {
  assert.equal(flankSurfaceRequest(grid, { ...of, axes: undefined }), undefined);
  assert.equal(
    flankSurfaceRequest(grid, { ...of, axes: { ...axes, z: { quantity: "deviation", unit: "foo" } } }),
    undefined,
  );
  assert.equal(flankSurfaceRequest({ type: "curve", x: [1, 2], y: [1, 2] }, of), undefined);
  assert.equal(flankSurfaceRequest(grid, { ...of, spec: { exclude: [{ row: 1, column: 1 }] } }), undefined);
  assert.equal(flankSurfaceRequest(grid, { ...of, spec: { regularization: { type: "attraction" } } }), undefined);
  const weight = [
    [1, 2],
    [1, 1],
  ];
  assert.equal(flankSurfaceRequest({ ...grid, weight }, of), undefined);
});

test("the surface of second order has six terms", () => {
  assert.equal(isSecondOrder({ type: "polynomial", degree: [2, 2], terms: "total" }), true);
  assert.equal(isSecondOrder({ type: "polynomial", degree: [2, 2] }), false);
  assert.equal(isSecondOrder({ type: "polynomial", degree: 3, terms: "total" }), false);
});
