// Files of measurements before they are sent, and the request made of the fields.

import assert from "node:assert/strict";
import { readFile as bytesOf } from "node:fs/promises";
import { test } from "node:test";
import { proposed, readFile } from "../../app/measure/read.js";
import { inWords, likelyAlong, likelyFlank, likelyUnit } from "../../app/measure/likely.js";
import { EMPTY, answered, importSpecOf, nodeOfPointer, specOf, wrongNumbers } from "../../app/measure/request.js";

const read = (/** @type {string} */ name, /** @type {string} */ text) => readFile(name, new TextEncoder().encode(text));

test("a request of examples/ is a grid with its counts, and keeps what it says of the fit", async () => {
  const content = readFile("a.json", await bytesOf(new URL("../../../examples/flank_z52.json", import.meta.url)));
  assert.deepEqual([content.kind, content.form, content.nodes, content.missing], ["json", "grid", 135, 3]);
  const spec = specOf({ ...EMPTY, operator: " A. B. " }, content);
  assert.deepEqual(spec["model"], content.request?.["model"]);
  assert.deepEqual(spec["regularization"], content.request?.["regularization"]);
  assert.equal(spec["operator"], "A. B.");
  assert.ok(!("nodes" in spec));
  const changed = specOf({ ...EMPTY, model: "other", degreeU: "3", degreeV: "1", regularization: "gcv" }, content);
  assert.deepEqual(changed["model"], { type: "polynomial", degree: [3, 1], basis: "legendre" });
  assert.deepEqual(changed["regularization"], { type: "spectral", lambda_star: { criterion: "gcv" } });
});

/** A table as the server would read it: a grid of u, v and z. @param {string} name @param {number[][]} z @param {number[]} [u] */
const table = (name, z, u = z.map((_, i) => i + 1)) =>
  proposed(
    read(name, "u,v,z\n"),
    /** @type {any} */ ({
      columns: [],
      layout: "grid",
      nodes: z.flat().length,
      missing: 0,
      read: { type: "grid", u, v: (z[0] ?? []).map((_, j) => j + 1), z },
    }),
  );

test("other files are known by what is in them", () => {
  for (const text of ["id,x,y,z\n1,2,3,4\n", "[A]\n1;2;3\n", "a,b\n1,2"])
    assert.equal(read("a.csv", text).kind, "table");
  assert.equal(read("a.txt", "<?xml version='1.0'?><model/>").form, "rexs");
  assert.equal(read("gear.mka", "HEADER").form, "mka");
  assert.equal(read("gear.mew", "HEADER").kind, "values");
  assert.equal(read("a.csv", "").failure, "empty");
  assert.equal(read("a.json", "{").failure, "json");
  assert.equal(read("a.json", '{"model": {}}').failure, "nodes");
});

test("a cell that is no number is marked by the pointer that the server will name", () => {
  const { doubts } = read("a.json", '{"nodes":{"type":"grid","u":[1,2],"v":[1,2],"z":[[1,2],[null,"n/a"]]}}');
  assert.deepEqual(doubts, [{ place: "/nodes/z/1/1", found: '"n/a"' }]);
  assert.deepEqual(nodeOfPointer("/nodes/z/3/7"), { row: 3, column: 7 });
  assert.equal(nodeOfPointer("/nodes/u/3"), undefined);
});

test("fields become filters, axes and what is said of an import; wrong numbers are found", () => {
  const typed = { ...EMPTY, hampel: "on", gaussian: "u", cutoff: "0,8", axes: "roll_length", conditionLimit: "500" };
  const spec = specOf(
    typed,
    table("a.csv", [
      [2, 1],
      [0, 4],
    ]),
  );
  assert.deepEqual(spec["filters"], [{ type: "hampel" }, { type: "gaussian", cutoff: 0.8, axis: "u" }]);
  assert.deepEqual(spec["regularization"], { type: "spectral", condition_limit: 500 });
  assert.deepEqual(Object.keys(/** @type {object} */ (spec["axes"])), ["u", "v", "z"]);
  assert.deepEqual(importSpecOf({ ...EMPTY, tooth: "7", flank: "right" }), { flank: "right", tooth: "7" });
  assert.deepEqual(wrongNumbers({ ...EMPTY, gaussian: "u", conditionLimit: "x", measuredAt: "soon" }), {
    conditionLimit: true,
    cutoff: true,
    measuredAt: true,
  });
  assert.deepEqual(wrongNumbers(EMPTY), {});
});

test("what a table most likely is, is found and said in words", () => {
  const grid = (/** @type {number} */ scale, /** @type {number[]} */ u) =>
    table(
      "left flank.csv",
      u.map((x) => [1, 2, 3].map((v) => (x * v - 20) * scale)),
      u,
    );
  const gear = /** @type {import("../../app/measure/likely.js").Gear} */ ({ teeth: 52, normal_module_mm: 1 });
  const roll = [5.9, 8, 11.4];
  for (const [unit, scale] of /** @type {const} */ ([
    ["um", 1],
    ["mm", 1e-3],
    ["nm", 1e3],
    ["in", 1 / 25_400],
  ])) {
    const { surface } = grid(scale, roll);
    assert.equal(likelyUnit(surface), unit === "in" ? "mm" : unit, unit);
    const { greatest = 0, from, to } = inWords(surface, unit) ?? {};
    assert.ok(Math.abs(greatest - 14.2) < 0.2, `${unit}: ${greatest}`);
    assert.deepEqual([from, to], [5.9, 11.4]);
  }
  assert.equal(likelyAlong(grid(1, roll).surface, gear), "roll_length");
  assert.equal(likelyAlong(grid(1, [50.5, 52, 53.9]).surface, gear), "diameter");
  assert.equal(likelyAlong(grid(1, roll).surface, undefined), undefined);
  const named = ["Links_1.csv", "pinion right.csv", "left-right.csv", "mill.csv"].map(likelyFlank);
  assert.deepEqual(named, ["left", "right", "", ""]);
  const of = { name: "left.csv", gear };
  const chosen = answered({ ...EMPTY, flank: "right" }, grid(1e-3, roll), of);
  assert.deepEqual([chosen.flank, chosen.axes, chosen.unit], ["right", "roll_length", "mm"]);
  const spec = specOf(answered(EMPTY, grid(1e-3, roll), of), grid(1e-3, roll));
  assert.equal(spec["flank"], "left");
  assert.deepEqual(spec["axes"], {
    u: { quantity: "roll_length", unit: "mm" },
    v: { quantity: "face_width", unit: "mm" },
    z: { quantity: "deviation", unit: "mm" },
  });
});
