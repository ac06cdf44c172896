// The changes of an edited job, and their merge with another's changes.

import assert from "node:assert/strict";
import { test } from "node:test";
import { editOf, patchOf, rebased } from "../../app/lib/job_edit.js";

/** @typedef {import("../../app/lib/job_edit.js").Job} Job */

const gear = { teeth: 52, normal_module_mm: 1, face_width_mm: 14 };
const stored = /** @type {Job} */ (
  /** @type {unknown} */ ({ name: "a", machine: "one", serial_number: "7", tags: { shift: "2", line: "b" }, gear })
);
const from = editOf(stored, String);

test("only what was changed is sent", () => {
  assert.deepEqual(patchOf(from, from), {});
  const job = { ...from.job, machine: " two ", serial_number: "" };
  assert.deepEqual(patchOf({ ...from, job }, from), { machine: "two", clear: ["serial_number"] });
  assert.deepEqual(patchOf({ ...from, job: { ...from.job, tags: "line = b\nshift = 3" } }, from), {
    tags: { line: "b", shift: "3" },
  });
  assert.deepEqual(patchOf({ ...from, gear: { ...from.gear, face_width_mm: "16,5" } }, from), {
    gear: { ...gear, face_width_mm: 16.5 },
  });
  assert.deepEqual(patchOf({ ...from, withGear: false }, from), { clear: ["gear"] });
  assert.equal(patchOf({ ...from, job: { ...from.job, name: " " } }, from), undefined);
  assert.equal(patchOf({ ...from, gear: { ...from.gear, teeth: "x" } }, from), undefined);
});

test("over another version the user's own changes are made, field by field", () => {
  const theirs = editOf(
    { ...stored, name: "b", tags: { shift: "2", line: "c" }, gear: { ...gear, teeth: 53 } },
    String,
  );
  const mine = {
    ...from,
    job: { ...from.job, machine: "two", tags: "shift = 3\nline = b" },
    gear: { ...from.gear, face_width_mm: "16" },
  };
  assert.deepEqual(patchOf(rebased(mine, from, theirs), theirs), {
    machine: "two",
    tags: { shift: "3", line: "c" },
    gear: { ...gear, teeth: 53, face_width_mm: 16 },
  });
  const { gear: _, ...noGear } = stored;
  const without = editOf(noGear, String);
  assert.deepEqual(patchOf(rebased(from, from, without), without), {});
  assert.deepEqual(patchOf(rebased(mine, from, without), without)?.gear, { ...gear, face_width_mm: 16 });
});
