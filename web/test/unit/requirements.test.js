// The requirements of a job: the form, its request, and the small flank of its figures.

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { test } from "node:test";
import { editOf, patchOf, rebased } from "../../app/lib/job_edit.js";
import {
  designPlace,
  emptyBand,
  heightAt,
  limitPointer,
  placeOf,
  pointsOf,
  requiredLimits,
  requirementsForm,
  requirementsOf,
  requirementsRebased,
} from "../../app/lib/requirements.js";
import { COLUMNS, heightsOf, materialAt, pixelsOf, ROWS } from "../../app/lib/thumbnail.js";

const example = JSON.parse(
  await readFile(new URL("../../../examples/requests/job_requirements.json", import.meta.url), "utf8"),
);

test("the form of requirements says what they say, with point and with comma", () => {
  const german = (/** @type {number} */ value) => String(value).replace(".", ",");
  for (const write of [String, german]) {
    const { requirements, errors } = requirementsOf(requirementsForm(example.requirements, write));
    assert.deepEqual(requirements, example.requirements);
    assert.deepEqual(errors, {});
  }
  assert.equal(requirementsOf(requirementsForm(undefined, String)).requirements, undefined);
});

test("a design is typed for both flanks, and keeps what the form has no fields for", () => {
  const design = { profile_crowning_um: 4, left: { twist_um: 1 }, modifications: [{ type: "twist", amount_um: 2 }] };
  const form = requirementsForm(/** @type {any} */ ({ design }), String);
  assert.deepEqual(requirementsOf(form).requirements, { design });
  form.design = { profile_crowning: "", helix_crowning: "5,5", twist: "x" };
  const { requirements, errors } = requirementsOf(form);
  assert.deepEqual(errors, { [designPlace("twist")]: "notANumber" });
  const { profile_crowning_um: _, ...others } = design;
  assert.deepEqual({ ...requirements?.design, twist_um: 0 }, { ...others, helix_crowning_um: 5.5, twist_um: 0 });
  assert.deepEqual(requirementsOf(requirementsForm({ design: {} }, String)).requirements, { design: {} });
});

test("errors of requirements are reported at their fields", () => {
  const form = requirementsForm(example.requirements, String);
  form.limits[placeOf("both", "twist", 0)] = "5";
  form.limits[placeOf("left", "helix_slope", 1)] = "x";
  form.limits[placeOf("both", "profile_form", 1)] = "";
  form.bands.push({ ...emptyBand(), upper: "0 1\n0 2", lower: "0 1 2\n3 4" });
  assert.deepEqual(requirementsOf(form).errors, {
    [placeOf("both", "twist", 0)]: "order",
    [placeOf("left", "helix_slope", 0)]: "notANumber",
    [placeOf("both", "profile_form", 0)]: "twoEnds",
    "band 2 upper": "points",
    "band 2 lower": "points",
  });
  assert.deepEqual(pointsOf("0; 1,5\n\n 7,5\t\u22122 \n"), [
    [0, 1.5],
    [7.5, -2],
  ]);
});

test("requirements are sent whole where they were touched, and cleared where nothing is left", () => {
  const job = /** @type {import("../../app/lib/job_edit.js").Job} */ (
    /** @type {unknown} */ ({ name: "a", tags: {}, requirements: example.requirements })
  );
  const from = editOf(job, String);
  assert.deepEqual(patchOf(from, from), {});
  const mine = { ...from, requirements: { ...from.requirements, class: "5" } };
  const wanted = structuredClone(example.requirements);
  wanted.tolerance_limits.class = 5;
  assert.deepEqual(patchOf(mine, from), { requirements: wanted });
  assert.deepEqual(patchOf({ ...from, requirements: { class: "", limits: {}, bands: [] } }, from), {
    clear: ["requirements"],
  });
  // others have set another limit meanwhile: both are kept
  const theirs = structuredClone(from);
  theirs.requirements.limits[placeOf("both", "twist", 1)] = "7";
  const both = patchOf(rebased(mine, from, theirs), theirs)?.requirements;
  assert.deepEqual([both?.tolerance_limits?.class, both?.tolerance_limits?.twist_um], [5, [-4, 7]]);
});

test("pitches and run-out have limits and a class of their own, separate from those of the flanks", () => {
  const requirements = {
    tolerance_limits: { class: 6 },
    pitch_limits: { class: 4, cumulative_pitch_um: [0, 20], runout_um: [0, 18], right: { single_pitch_um: [-6, 5] } },
  };
  const form = requirementsForm(requirements, String);
  assert.deepEqual(requirementsOf(form).requirements, requirements);
  form.limits[placeOf("both", "runout", 1)] = "";
  assert.deepEqual(requirementsOf(form).errors, { [placeOf("both", "runout", 0)]: "twoEnds" });
  // somebody else changes the class of pitches, while a limit of theirs is changed here
  const from = requirementsForm(requirements, String);
  const mine = structuredClone(from);
  mine.limits[placeOf("both", "runout", 1)] = "15";
  const both = requirementsOf(requirementsRebased(mine, from, { ...structuredClone(from), pitchClass: "5" }));
  assert.deepEqual(both.requirements?.pitch_limits, { ...requirements.pitch_limits, class: 5, runout_um: [0, 15] });
  assert.deepEqual(
    [limitPointer("both", "runout"), limitPointer("left", "single_pitch"), limitPointer("right", "twist")],
    [
      "/requirements/pitch_limits/runout_um",
      "/requirements/pitch_limits/left/single_pitch_um",
      "/requirements/tolerance_limits/right/twist_um",
    ],
  );
});

test("required limits of a figure: those of its flank, then of both, then the tolerance of the class", () => {
  const { requirements } = example;
  const tolerances = /** @type {import("../../app/api/client.js").Schema<"ToleranceValues">} */ (
    /** @type {unknown} */ ({ profile_slope_um: 6.5, helix_slope_um: 8 })
  );
  assert.deepEqual(requiredLimits(requirements, "left", "helix_slope", tolerances), [-6, 2]);
  assert.deepEqual(requiredLimits(requirements, undefined, "helix_slope", tolerances), [-8, 8]);
  assert.deepEqual(requiredLimits(requirements, "right", "profile_slope", tolerances), [-6.5, 6.5]);
  assert.deepEqual(requiredLimits(requirements, "right", "twist", tolerances), [-4, 4]);
  assert.equal(requiredLimits({ tolerance_limits: { class: 6 } }, "left", "twist", tolerances), undefined);
  assert.equal(requiredLimits(undefined, "left", "profile_slope", undefined), undefined);
});

test("what the form has no fields for stays as it is", () => {
  const requirements = { ...example.requirements, to_come: { class: 5 } };
  const form = requirementsForm(requirements, String);
  assert.deepEqual(requirementsOf(form).requirements, requirements);
  form.class = "";
  form.limits = {};
  form.design = {};
  form.bands = [];
  assert.deepEqual(requirementsOf(form).requirements, { to_come: { class: 5 } });
});

test("a line is straight between its points and undefined outside them", () => {
  const line = [
    [0, 4],
    [8, 4],
    [10, 0],
  ];
  assert.deepEqual(
    [-0.1, 0, 8, 9, 10, 10.1].map((at) => heightAt(line, at)),
    [undefined, 4, 4, 2, 0, undefined],
  );
});

test("the small flank has the figures that it is drawn of", () => {
  const figures = {
    profile_slope_um: 6,
    helix_slope_um: -4,
    profile_crowning_um: 3,
    helix_crowning_um: 5,
    twist_um: 8,
  };
  const at = (/** @type {number} */ u, /** @type {number} */ v) => materialAt({ figures, flank: "left" }, u, v);
  const near = (/** @type {number} */ a, /** @type {number} */ b) => assert.ok(Math.abs(a - b) < 1e-12, `${a} ${b}`);
  near(at(1, 0) - at(-1, 0), 6);
  near(at(0, 1) - at(0, -1), -4);
  near(at(0, 0) - (at(1, 0) + at(-1, 0)) / 2, 3);
  near(at(0, 0) - (at(0, 1) + at(0, -1)) / 2, 5);
  near(at(1, 1) - at(-1, 1) - (at(1, -1) - at(-1, -1)), 8);
  const heights = heightsOf({ figures, flank: "left" });
  assert.ok(Math.abs(heights.reduce((sum, one) => sum + one, 0) / heights.length) < 0.1, "about its mean");
  // the first row is the tip's
  assert.ok((heights[0] ?? 0) > (heights[(ROWS - 1) * COLUMNS] ?? 0));
  // an unknown one is a left one
  assert.deepEqual(heightsOf({ figures }), heights);
});

test("the same helix has its material at the other end on a right flank", () => {
  // material increases towards face II: to the right hand on left flanks, to the left hand on right
  // ones
  const rising = { left: 4, right: -4 };
  const growing = { left: 8, right: -8 };
  const [left, right] = /** @type {const} */ (["left", "right"]).map((flank) => {
    const figures = {
      profile_slope_um: 6,
      helix_slope_um: rising[flank],
      twist_um: growing[flank],
      helix_crowning_um: 2,
    };
    return heightsOf({ figures, flank });
  });
  assert.deepEqual(right, left);
  // face I is left: the middle of the flank rises by the slope, but for the width of a column
  const row = heightsOf({ figures: { helix_slope_um: rising.right }, flank: "right" }).slice(0, COLUMNS);
  const rise = (row.at(-1) ?? 0) - (row[0] ?? 0);
  assert.ok(Math.abs(rise - 4 * (1 - 1 / COLUMNS)) < 1e-12, `${rise}`);
  assert.deepEqual(
    pixelsOf({ figures: { helix_slope_um: 4 }, flank: "right" }, 5),
    pixelsOf({ figures: { helix_slope_um: -4 }, flank: "left" }, 5),
  );
});
