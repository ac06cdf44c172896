// Fields of forms. An error of the server is shown at the field of its JSON Pointer.

import { errorsAt } from "../api/problem.js";
import { t } from "../i18n/common.js";
import { h, html, useId } from "../../vendor/ui.js";

/** @typedef {import("../../vendor/ui.js").ComponentChildren} Children */
/**
 * @typedef {object} FieldProps
 * @property {Children} label
 * @property {Children} [hint] what to enter
 * @property {string} [unit]
 * @property {boolean} [required]
 * @property {unknown} [error] of the request; its errors at `pointer` are shown
 * @property {string} [pointer]
 * @property {string | undefined} [fieldError] what is wrong, found here
 */

/**
 * A label, its control, and below it an error or a hint.
 * @param {FieldProps & { control: (ids: { id: string, describedBy: string | undefined, invalid: boolean }) => Children }} props
 */
export function Field({ label, hint, unit, required = false, error, pointer, fieldError, control }) {
  const id = useId();
  const errors = pointer === undefined ? [] : errorsAt(error, pointer);
  const wrong = fieldError !== undefined || errors.length > 0;
  const described = [wrong && `${id}-error`, hint && `${id}-hint`].filter(Boolean).join(" ");
  return html`<div class="field">
    <label for=${id}>${label}${!required && html` <span class="optional">${t.optional}</span>`}</label>
    <div class="control">
      ${control({ id, describedBy: described || undefined, invalid: wrong })}
      ${unit && html`<span class="unit" translate="no">${unit}</span>`}
    </div>
    <div class="notes">
      ${
        wrong &&
        html`<p class="field-error" id=${`${id}-error`}>
          ${fieldError}${errors.map((one) => html`<span key=${one.pointer} lang="en">${one.detail}</span>`)}
        </p>`
      }
      ${hint && html`<p class="hint" id=${`${id}-hint`}>${hint}</p>`}
    </div>
  </div>`;
}

/**
 * A line of text, or a number, which `parseNumber` reads with point or comma.
 * @param {FieldProps & {
 *   value: string, onInput: (value: string) => void, type?: "text" | "password" | "search" | "date", numeric?: boolean,
 *   maxLength?: number, autocomplete?: string, lines?: number,
 * }} props
 */
export function TextField({
  value,
  onInput,
  type = "text",
  numeric = false,
  maxLength,
  autocomplete = "off",
  lines,
  ...field
}) {
  const take = (
    /** @type {import("../../vendor/ui.js").TargetedEvent<HTMLInputElement | HTMLTextAreaElement>} */ event,
  ) => onInput(event.currentTarget.value);
  return h(Field, {
    ...field,
    control: ({ id, describedBy, invalid }) => {
      const common = { id, value, onInput: take, maxLength, autocomplete, required: field.required };
      const aria = {
        "aria-describedby": describedBy,
        "aria-invalid": invalid ? /** @type {const} */ ("true") : undefined,
      };
      if (lines) return html`<textarea ...${common} ...${aria} rows=${lines}></textarea>`;
      return html`<input ...${common} ...${aria} type=${type} class=${numeric ? "numeric" : ""}
        inputmode=${numeric ? "decimal" : undefined} spellcheck=${false} />`;
    },
  });
}

/**
 * A choice of a few values.
 * @param {FieldProps & { value: string, onChange: (value: string) => void, options: readonly { value: string, label: Children, verbatim?: boolean }[] }} props
 * A `verbatim` option, such as a unit, is not translated.
 */
export function SelectField({ value, onChange, options, ...field }) {
  return h(Field, {
    ...field,
    control: ({ id, describedBy, invalid }) =>
      html`<select id=${id} value=${value} aria-describedby=${describedBy} aria-invalid=${invalid ? "true" : undefined}
        onChange=${(/** @type {import("../../vendor/ui.js").TargetedEvent<HTMLSelectElement>} */ event) => onChange(event.currentTarget.value)}>
        ${options.map((option) => html`<option key=${option.value} value=${option.value} translate=${option.verbatim ? "no" : undefined}>${option.label}</option>`)}
      </select>`,
  });
}

/** @param {{ label: Children, checked: boolean, onChange: (checked: boolean) => void }} props */
export function Checkbox({ label, checked, onChange }) {
  return html`<label class="checkbox">
    <input type="checkbox" checked=${checked}
      onChange=${(/** @type {import("../../vendor/ui.js").TargetedEvent<HTMLInputElement>} */ event) => onChange(event.currentTarget.checked)} />
    <span>${label}</span>
  </label>`;
}

/** Focuses the first invalid field, once it is marked, and opens the sections around it. @param {HTMLElement | null} form */
export function toFirstError(form) {
  requestAnimationFrame(() => {
    const field = form?.querySelector('[aria-invalid="true"]');
    if (!(field instanceof HTMLElement)) return;
    for (let around = field.closest("details"); around; around = around.parentElement?.closest("details") ?? null)
      around.open = true;
    field.focus();
  });
}
