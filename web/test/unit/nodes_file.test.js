import assert from "node:assert/strict";
import { test } from "node:test";
import { isJson, readNodes, specOf, textOfTable } from "../../app/lib/nodes_file.js";

/** @param {string} text */
const read = (text) => {
  const { file } = readNodes(text);
  assert.ok(file);
  return file;
};

test("a table that the server has read is a request with its axes", () => {
  const axes = { z: { quantity: "deviation", unit: "um" } };
  const nodes = { type: "curve", x: [0, 1], y: [1, 2] };
  const proposal = /** @type {any} */ ({
    read: nodes,
    axes,
    flanks: [{ flank: "left", tooth: "1", nodes: 2, missing: 0 }],
  });
  const file = read(textOfTable(proposal));
  assert.deepEqual(file.spec, { axes, flank: "left", tooth: "1" });
  assert.deepEqual([file.nodes, file.count], [nodes, 2]);
  assert.deepEqual(["\uFEFF {", "[1]", "u,v", "[A]\n1;2"].map(isJson), [true, true, false, false]);
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

test("anything else is reported", () => {
  const failure = (/** @type {string} */ text) => readNodes(text).failure;
  assert.equal(failure(" \n"), "empty");
  assert.equal(failure("{"), "json");
  assert.equal(failure("[1, 2]"), "noNodes");
  assert.equal(failure('{"nodes": {"type": "cloud"}}'), "noNodes");
});

test("the file's spec is kept unless something else is chosen", () => {
  const regularization = { type: "spectral", count: 2, lambda_star: { criterion: "min_mse" } };
  const nodes = { type: "scattered", u: [0], v: [0], z: [1] };
  const file = read(JSON.stringify({ nodes, model: { type: "polynomial", degree: 3 }, regularization }));
  assert.deepEqual(specOf(file, {})["model"], { type: "polynomial", degree: 3 });
  const chosen = specOf(file, { degree: "1", by: "gcv" });
  assert.deepEqual(chosen["model"], { type: "polynomial", degree: [1, 1], basis: "legendre" });
  assert.deepEqual(chosen["regularization"], { ...regularization, lambda_star: { criterion: "gcv" } });
  assert.deepEqual(specOf(read('{"type":"curve","x":[0],"y":[1]}'), { by: "none" }), {
    model: { type: "polynomial", degree: 2, basis: "legendre" },
    regularization: { type: "none" },
    include: ["residuals", "fitted", "intervals"],
  });
});
