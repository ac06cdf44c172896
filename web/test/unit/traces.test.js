import assert from "node:assert/strict";
import { test } from "node:test";
import {
  asPosted,
  hangingBand,
  highest,
  magnification,
  outsideBy,
  requiredBands,
  rollLength,
  sheetOf,
} from "../../app/lib/traces.js";

const gear = { teeth: 52, normal_module_mm: 1, normal_pressure_angle_deg: 20, face_width_mm: 15 };
const evaluated = /** @type {import("../../app/lib/traces.js").EvaluatedTrace} */ (
  /** @type {unknown} */ ({ tooth: "1", flank: "left", kind: "helix", slope_um: 3 })
);

test("roll lengths begin at the base circle", () => {
  const base = 52 * Math.cos(Math.PI / 9);
  assert.equal(rollLength(gear, base), 0);
  assert.ok(Math.abs(rollLength(gear, 52) - 26 * Math.sin(Math.PI / 9)) < 1e-12);
});

const helix = (/** @type {object} */ change = {}) =>
  /** @type {import("../../app/lib/traces.js").GearTrace} */ ({
    tooth: "1",
    flank: "left",
    kind: "helix",
    z_mm: [0, 5, 10, 15],
    deviation_um: [9, -1, 1, null],
    ...change,
  });
const means = { ...evaluated, range_mm: [5, 10], mean_line_um: [-0.5, 0.5], mean_parabola_um: [-0.5, 2, 0.5] };

test("mean lines and parabolas are those of the result, over the design line", () => {
  const sheet = sheetOf(helix(), means, {}, gear);
  assert.deepEqual(sheet.range, [5, 10]);
  assert.deepEqual(sheet.mean, [
    { at: 5, value: -0.5 },
    { at: 10, value: 0.5 },
  ]);
  assert.deepEqual(
    [0, 12, 24].map((i) => sheet.parabola[i]),
    [
      { at: 5, value: -0.5 },
      { at: 7.5, value: 2 },
      { at: 10, value: 0.5 },
    ],
  );
  const designed = sheetOf(helix({ design_um: [0, 1, 3, 4] }), means, {}, gear);
  assert.deepEqual(designed.mean, [
    { at: 5, value: 0.5 },
    { at: 10, value: 3.5 },
  ]);
  const answered = { ...means, design_um: [0, 2, 4, 6] };
  assert.deepEqual(sheetOf(helix({ design_um: [0, 1, 3, 4] }), answered, {}, gear).mean[1], { at: 10, value: 4.5 });
  assert.deepEqual(sheetOf(helix(), answered, { against: "involute" }, gear).mean, sheet.mean, "about the involute");
  assert.deepEqual(sheetOf(helix(), evaluated, {}, gear).mean, [], "not where there was no answer");
});

test("a band hangs from the highest point within the range", () => {
  const sheet = sheetOf(helix(), means, {}, gear);
  assert.equal(highest(sheet), 1, "of samples within the range");
  const [band] = hangingBand(sheet, 1.5);
  assert.deepEqual(
    sheet.samples.map((sample, i) => outsideBy(sample, band?.limits[i])),
    [0, -0.5, 0, 0],
  );
});

test("required bands are shifted to fit the trace, in its posted sign", () => {
  const k_bands = [
    {
      kind: /** @type {const} */ ("helix"),
      upper: [
        [0, 2],
        [15, 2],
      ],
      lower: [
        [0, -4],
        [7.5, -2],
        [15, -4],
      ],
    },
  ];
  const found = { ...means, k_bands: [{ band: 0, within: false, clearance_um: -1, shift_um: 3, nearest_mm: [0, 5] }] };
  const drawn = (/** @type {"left" | "right"} */ flank, /** @type {object} */ settings) => {
    const trace = helix({ flank });
    const all = { k_bands, ...settings };
    return requiredBands(sheetOf(trace, found, all, gear), trace, found, all, gear)[0];
  };
  // left: material is positive
  assert.deepEqual(drawn("left", {})?.upper, [
    { at: 0, value: -1 },
    { at: 15, value: -1 },
  ]);
  assert.deepEqual(drawn("left", {})?.limits[1], { low: -7 + 2 * (5 / 7.5), high: -1 });
  // right flanks in the sign of DIN: space is positive, so the lower line lies above
  assert.deepEqual(drawn("right", {})?.lower, [
    { at: 0, value: 1 },
    { at: 15, value: 1 },
  ]);
  assert.deepEqual(drawn("right", { deviation_sign: "material" })?.upper[0], { at: 0, value: -1 });
  assert.equal(outsideBy({ at: 0, value: 9, design: 0, inside: true }, { low: -1, high: 2 }), 7);
});

test("a band about the design follows its line, whatever the figures are about", () => {
  const band = { kind: /** @type {const} */ ("helix"), against: /** @type {const} */ ("design") };
  const line = (/** @type {number} */ value) => [
    [0, value],
    [15, value],
  ];
  const settings = {
    against: /** @type {const} */ ("involute"),
    k_bands: [{ ...band, upper: line(1), lower: line(-1) }],
  };
  const found = {
    ...means,
    design_um: [0, 2, 4, 6],
    k_bands: [{ band: 0, within: true, clearance_um: 1, shift_um: 0.5, nearest_mm: [0, 5] }],
  };
  const drawn = requiredBands(sheetOf(helix(), found, settings, gear), helix(), found, settings, gear)[0];
  assert.deepEqual(
    drawn?.upper.map(({ value }) => value),
    [0.5, 2.5, 4.5, 6.5],
  );
  assert.deepEqual(drawn?.limits[3], { low: 4.5, high: 6.5 });
});

test("signs and directions of posted deviations", () => {
  const signs = (/** @type {object} */ settings, /** @type {object} */ trace) =>
    asPosted(settings, helix(trace), { ...gear, helix_angle_deg: 30 });
  assert.equal(signs({ deviation_sign: "clockwise" }, {}), -1);
  assert.equal(signs({ deviation_sign: "clockwise" }, { flank: "right" }), 1);
  assert.equal(signs({ sign: "vdi" }, { flank: "right" }), 1);
  assert.equal(signs({}, { kind: "profile", flank: "right" }), 1);
  const beta = Math.asin(Math.sin(Math.PI / 6) * Math.cos(Math.PI / 9));
  assert.ok(Math.abs(signs({ direction: "normal" }, {}) - Math.cos(beta)) < 1e-15);
});

test("magnifications are those of testers", () => {
  assert.equal(magnification(5.5, 85), 10);
  assert.equal(magnification(0.012, 40), 3000);
});
