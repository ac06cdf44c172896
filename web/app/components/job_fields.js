// The fields of a job, new or edited.

import de from "../i18n/de/new_job.js";
import en from "../i18n/en/new_job.js";
import { texts } from "../i18n/i18n.js";
import { tagsOf } from "../lib/gear_form.js";
import { h, html, useState } from "../../vendor/ui.js";
import { TextField } from "./form.js";

/** @typedef {import("../lib/job_edit.js").JobForm} JobForm */

const t = texts({ en, de });

/** @type {JobForm} */
export const emptyJob = { name: "", part_number: "", serial_number: "", machine: "", tags: "" };

/** @param {{ form: JobForm, onChange: (form: JobForm) => void, error: unknown, submitted: boolean }} props */
export function JobFields({ form, onChange, error, submitted }) {
  const set = (/** @type {keyof JobForm} */ name) => (/** @type {string} */ value) =>
    onChange({ ...form, [name]: value });
  /** @param {Exclude<keyof JobForm, "tags">} name @param {string} label */
  const line = (name, label) =>
    h(TextField, {
      key: name,
      label,
      value: form[name],
      onInput: set(name),
      maxLength: 200,
      required: name === "name",
      error,
      pointer: `/${name}`,
      fieldError: submitted && name === "name" && form.name.trim() === "" ? t.needed : undefined,
    });
  const [tagged] = useState(form.tags !== "");
  return html`<div class="fields">
    ${line("name", t.name)} ${line("part_number", t.part)} ${line("serial_number", t.serial)} ${line("machine", t.machine)}
  </div>
    <details open=${tagged}>
      <summary>${t.tagsNow}</summary>
      ${h(TextField, {
        label: t.tags,
        hint: t.tagsHint,
        value: form.tags,
        onInput: set("tags"),
        lines: 2,
        error,
        pointer: "/tags",
        fieldError: tagsOf(form.tags) === undefined ? t.tagsInvalid : undefined,
      })}
    </details>`;
}
