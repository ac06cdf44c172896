import assert from "node:assert/strict";
import { test } from "node:test";
import { readNodes, specOf } from "../../app/lib/nodes_file.js";

/** @param {string} text */
const read = (text) => {
  const { file } = readNodes(text);
  assert.ok(file);
  return file;
};

test("CSV: places, heights, weights, missing heights", () => {
  const file = read('\uFEFF"u","v",z,weight\r\n1,2,3.5,1\r\n2,2,,1\r\n\r\n3,1,-4e-1,0\r\n');
  assert.equal(file.kind, "csv");
  assert.deepEqual(file.nodes, {
    type: "scattered",
    u: [1, 2, 3],
    v: [2, 2, 1],
    z: [3.5, Number.NaN, -0.4],
    weight: [1, 1, 0],
  });
  assert.deepEqual([file.count, file.missing], [3, 1]);
  const curve = read("x,y\n0,1\n1,2\n");
  assert.deepEqual([curve.nodes.type, curve.count], ["curve", 2]);
});

test("JSON: nodes alone, and a request of an iteration", () => {
  const nodes = {
    type: "grid",
    u: [0, 1],
    v: [0, 1],
    z: [
      [1, null],
      [2, 3],
    ],
    valid: [
      [true, true],
      [false, true],
    ],
  };
  const alone = read(JSON.stringify(nodes));
  assert.deepEqual([alone.count, alone.missing, alone.spec], [4, 2, {}]);
  const whole = read(JSON.stringify({ nodes, model: { type: "polynomial", degree: 1 }, flank: "left", operator: "B" }));
  assert.deepEqual(whole.spec, { model: { type: "polynomial", degree: 1 }, flank: "left" });
  assert.deepEqual(whole.measurement, { operator: "B" });
});

test("what is none of these is told", () => {
  const fault = (/** @type {string} */ text) => readNodes(text).fault;
  assert.equal(fault(" \n"), "empty");
  assert.equal(fault("{"), "json");
  assert.equal(fault("[1, 2]"), "noNodes");
  assert.equal(fault('{"nodes": {"type": "cloud"}}'), "noNodes");
  assert.equal(fault("a;b\n1;2"), "header");
});

test("the file's spec stands unless something else is chosen", () => {
  const regularization = { type: "spectral", count: 2, lambda_star: { criterion: "min_mse" } };
  const nodes = { type: "scattered", u: [0], v: [0], z: [1] };
  const file = read(JSON.stringify({ nodes, model: { type: "polynomial", degree: 3 }, regularization }));
  assert.deepEqual(specOf(file, {})["model"], { type: "polynomial", degree: 3 });
  const chosen = specOf(file, { degree: "1", by: "gcv" });
  assert.deepEqual(chosen["model"], { type: "polynomial", degree: [1, 1], basis: "legendre" });
  assert.deepEqual(chosen["regularization"], { ...regularization, lambda_star: { criterion: "gcv" } });
  assert.deepEqual(specOf(read("x,y\n0,1"), { by: "none" }), {
    model: { type: "polynomial", degree: 2, basis: "legendre" },
    regularization: { type: "none" },
    include: ["residuals", "fitted", "intervals"],
  });
});
