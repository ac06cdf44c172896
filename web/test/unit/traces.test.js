import assert from "node:assert/strict";
import { test } from "node:test";
import { highest, isOutside, magnification, rollLength, sheetOf } from "../../app/lib/traces.js";

const gear = { teeth: 52, normal_module_mm: 1, normal_pressure_angle_deg: 20, face_width_mm: 15 };
const evaluated = /** @type {import("../../app/lib/traces.js").EvaluatedTrace} */ (
  /** @type {unknown} */ ({ tooth: "1", flank: "left", kind: "helix", slope_um: 3 })
);

test("roll lengths begin at the base circle", () => {
  const base = 52 * Math.cos(Math.PI / 9);
  assert.equal(rollLength(gear, base), 0);
  assert.ok(Math.abs(rollLength(gear, 52) - 26 * Math.sin(Math.PI / 9)) < 1e-12);
});

test("the mean line has the slope that was answered, over the reference length", () => {
  const trace = /** @type {import("../../app/lib/traces.js").GearTrace} */ ({
    tooth: "1",
    flank: "left",
    kind: "helix",
    z_mm: [0, 5, 10, 15],
    deviation_um: [9, -1, 1, null],
  });
  const settings = { helix_range_mm: [5, 10], helix_reference_length_mm: 15 };
  const sheet = sheetOf(trace, evaluated, settings, gear);
  assert.deepEqual(sheet.mean, [
    { at: 5, value: -0.5 },
    { at: 10, value: 0.5 },
  ]);
  assert.deepEqual(sheetOf(trace, evaluated, { ...settings, deviation_sign: "material" }, gear).mean, []);
  assert.equal(highest(sheet), 1, "of samples within the range");
  assert.deepEqual(
    sheet.samples.map((sample) => isOutside(sample, 1, 1.5)),
    [false, true, false, false],
  );
});

test("magnifications are those of testers", () => {
  assert.equal(magnification(5.5, 85), 10);
  assert.equal(magnification(0.012, 40), 3000);
});
