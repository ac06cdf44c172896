import assert from "node:assert/strict";
import { test } from "node:test";
import {
  draftOf,
  emptyDraft,
  newValue,
  presentOf,
  requestOf,
  settingsOf,
  isSuperseded,
  significant,
} from "../../app/lib/correction.js";

const write = (/** @type {number | null | undefined} */ value) => (typeof value === "number" ? String(value) : "");

test("a request becomes a draft and the same request again", () => {
  /** @type {import("../../app/lib/correction.js").CorrectionRequest} */
  const request = {
    sensitivity: { type: "machine", machine: "form_grinding", flank: "left", profile_axis: "roll_length" },
    limits: { profile_angle: { min: -20, max: 20, increment: 0.05 }, infeed: { fixed: true } },
    noise_sigma_um: 0.5,
    response_uncertainty: 0.02,
    absolute: false,
    target: { deviation_um: [1, -2.5] },
    settings_used: "all",
  };
  assert.deepEqual(requestOf(draftOf(request, write)), { request, errors: {} });
  /** @type {import("../../app/lib/correction.js").CorrectionRequest} */
  const matrix = {
    sensitivity: {
      type: "matrix",
      settings: ["a", "b/c"],
      units: ["µm", "′"],
      matrix: [
        [1, 0.5],
        [-1, 2e-3],
      ],
    },
  };
  assert.deepEqual(requestOf(draftOf(matrix, write)), { request: matrix, errors: {} });
});

test("without a target the job's own is aimed at", () => {
  const draft = { ...emptyDraft(true), target: "1 2" };
  assert.equal(requestOf(draft).request.target, undefined, "no zeros, and nothing that was typed before");
  assert.equal(requestOf({ ...draft, aim: "limits" }).request.target, "limits");
  assert.equal(draftOf(requestOf({ ...draft, aim: "limits" }).request, write).aim, "limits");
});

test("what is no number is found at its place", () => {
  const draft = {
    ...emptyDraft(false),
    matrix: "a [µm];b [µm]\n1;0,5\n2;x",
    aim: /** @type {const} */ ("given"),
    target: "1,5 2 y",
    noise: "a",
    limits: {
      a: { fixed: false, min: "?", max: "", increment: "0,5" },
      gone: { fixed: true, min: "", max: "", increment: "" },
    },
  };
  const { request, errors } = requestOf(draft);
  assert.deepEqual(errors, {
    "/limits/a/min": "number",
    "/noise_sigma_um": "number",
    "/target": "number",
    "/sensitivity/matrix": "row",
  });
  assert.ok(request.sensitivity.type === "matrix");
  assert.deepEqual(request.sensitivity.matrix[0], [1, 0.5], "commas are decimal with semicolons");
  assert.equal(request.limits?.["gone"], undefined, "limits of settings that are named no more stay unsaid");
  assert.deepEqual(settingsOf(draft), [
    { name: "a", unit: "µm" },
    { name: "b", unit: "µm" },
  ]);
});

test("a change is significant above the half width of its 95 % interval", () => {
  assert.equal(significant({ change: 0.024, std_error: 0.042 }), false);
  assert.equal(significant({ change: -14.89, std_error: 0.2 }), true);
  assert.equal(significant({ change: 3 }), true);
});

test("a new value is the sum of the one before and the change", () => {
  assert.equal(newValue("1,2", "0.1"), 1.3);
  assert.equal(newValue("10", "−0,52"), 9.48);
  assert.equal(newValue("", "0.33"), undefined);
  assert.equal(newValue("ten", "0.33"), undefined);
  const kept = { correction: "a", present: "10", next: "10.35" };
  assert.deepEqual([presentOf(kept, "a"), presentOf(kept, "b"), presentOf(undefined, "a")], ["10", "10.35", ""]);
});

test("values are superseded by those of a later correction, and by another's once a correction was entered", () => {
  const kept = { correction: "b", present: "10", next: "10.35" };
  assert.deepEqual(
    ["a", "b", "c"].map((id) => isSuperseded(kept, id, true)),
    [true, false, true],
  );
  assert.deepEqual(
    ["a", "b", "c"].map((id) => isSuperseded(kept, id, false)),
    [true, false, false],
  );
  assert.equal(isSuperseded(undefined, "a", true), false);
});
