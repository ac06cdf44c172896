// A job as it is edited: its fields as typed, the changes, and the same changes made to a version
// that somebody else has stored meanwhile. Pure.

import { formOf, gearOf, tagLines, tagsOf } from "./gear_form.js";
import { requirementsForm, requirementsOf, requirementsRebased } from "./requirements.js";

/** @typedef {import("../api/client.js").Schema<"Job">} Job */
/** @typedef {import("../api/client.js").Schema<"JobPatch">} JobPatch */
/** @typedef {import("./gear_form.js").GearForm} GearForm */
/** @typedef {{ name: string, part_number: string, serial_number: string, machine: string, tags: string }} JobForm */
/** @typedef {import("./requirements.js").RequirementsForm} RequirementsForm */
/** @typedef {{ job: JobForm, gear: GearForm, withGear: boolean, requirements: RequirementsForm }} JobEdit */

export const OPTIONAL = /** @type {const} */ (["part_number", "serial_number", "machine"]);
const LINES = /** @type {const} */ (["name", ...OPTIONAL]);

/** @param {Job} job @param {(value: number) => string} write @returns {JobEdit} */
export function editOf(job, write) {
  return {
    job: {
      name: job.name,
      part_number: job.part_number ?? "",
      serial_number: job.serial_number ?? "",
      machine: job.machine ?? "",
      tags: tagLines(job.tags),
    },
    gear: formOf(job.gear ?? undefined, write),
    withGear: job.gear != null,
    requirements: requirementsForm(job.requirements, write),
  };
}

/**
 * Returns the user's changes; an empty object without changes, undefined if the form is invalid.
 * @param {JobEdit} mine @param {JobEdit} from what the form began with @returns {JobPatch | undefined}
 */
export function patchOf(mine, from) {
  const tags = tagsOf(mine.job.tags);
  const gear = mine.withGear ? gearOf(mine.gear).gear : undefined;
  const { requirements, errors } = requirementsOf(mine.requirements);
  if (mine.job.name.trim() === "" || !tags || (mine.withGear && !gear)) return undefined;
  if (Object.keys(errors).length > 0) return undefined;
  /** @type {JobPatch} */
  const patch = {};
  /** @type {NonNullable<JobPatch["clear"]>} */
  const clear = [];
  for (const name of LINES) {
    const value = mine.job[name].trim();
    if (value === from.job[name].trim()) continue;
    if (name !== "name" && value === "") clear.push(name);
    else patch[name] = value;
  }
  if (!same(tags, tagsOf(from.job.tags))) patch.tags = tags;
  if (gear && !(from.withGear && same(gear, gearOf(from.gear).gear))) patch.gear = gear;
  if (!gear && from.withGear) clear.push("gear");
  if (!same(requirements, requirementsOf(from.requirements).requirements)) {
    if (requirements) patch.requirements = requirements;
    else clear.push("requirements");
  }
  if (clear.length > 0) patch.clear = clear;
  return patch;
}

/**
 * Applies the changes from `from` to `mine` to `theirs`: unchanged fields, tags and gear data stay
 * as they are there.
 * @param {JobEdit} mine @param {JobEdit} from @param {JobEdit} theirs @returns {JobEdit}
 */
export function rebased(mine, from, theirs) {
  const tags = (/** @type {JobEdit} */ edit) => tagsOf(edit.job.tags) ?? {};
  const gearChanged = mine.withGear !== from.withGear || !same(mine.gear, from.gear);
  return {
    job: {
      ...changed(mine.job, from.job, theirs.job),
      tags: tagLines(changed(tags(mine), tags(from), tags(theirs))),
    },
    gear: gearChanged && !theirs.withGear ? mine.gear : changed(mine.gear, from.gear, theirs.gear),
    withGear: gearChanged ? mine.withGear : theirs.withGear,
    requirements: requirementsRebased(mine.requirements, from.requirements, theirs.requirements),
  };
}

/** @template {Record<string, string>} Fields @param {Fields} mine @param {Fields} from @param {Fields} theirs @returns {Fields} */
function changed(mine, from, theirs) {
  const all = new Set([...Object.keys(theirs), ...Object.keys(mine)]);
  const kept = [...all].flatMap((name) => {
    const value = mine[name] === from[name] ? theirs[name] : mine[name];
    return value === undefined ? [] : [[name, value]];
  });
  return /** @type {Fields} */ (Object.fromEntries(kept));
}

/** @param {unknown} a @param {unknown} b */
const same = (a, b) => ordered(a) === ordered(b);

/** @param {unknown} value */
const ordered = (value) =>
  JSON.stringify(value, (_, one) =>
    one && typeof one === "object" && !Array.isArray(one)
      ? Object.fromEntries(Object.entries(one).sort(([a], [b]) => (a < b ? -1 : 1)))
      : one,
  );
