// The fields of the requirements of a job.

import { errorsAt } from "../api/problem.js";
import { t } from "../i18n/requirements.js";
import {
  ALL_FIGURES,
  bandPlace,
  CLASSES,
  designPlace,
  designPointer,
  emptyBand,
  FIGURES,
  limitPointer,
  PITCH_FIGURES,
  placeOf,
  requirementsOf,
  sidesOf,
  SURFACE_FIGURES,
} from "../lib/requirements.js";
import { h, html, useId } from "../../vendor/ui.js";
import { SelectField, TextField } from "./form.js";
import { GearSymbol } from "./symbol.js";

/** @typedef {import("../lib/requirements.js").RequirementsForm} RequirementsForm */
/** @typedef {import("../lib/requirements.js").BandForm} BandForm */
/** @typedef {import("../lib/requirements.js").Side} Side */
/** @typedef {readonly { name: import("../lib/requirements.js").FigureName, symbol: string }[]} Figures */
/** @typedef {import("../../vendor/ui.js").TargetedEvent<HTMLInputElement>} Typed */

/** JSON Pointers of errors that are shown at these fields. @param {RequirementsForm} form */
export const shownPointers = (form) => [
  "/requirements/tolerance_limits/class",
  "/requirements/pitch_limits/class",
  ...ALL_FIGURES.flatMap(({ name }) => sidesOf(name).map((side) => limitPointer(side, name))),
  ...SURFACE_FIGURES.map(({ name }) => designPointer(name)),
  ...form.bands.flatMap((_, i) => ["upper", "lower", "against"].map((of) => `/requirements/k_bands/${i}/${of}`)),
];

/** @param {{ form: RequirementsForm, onChange: (form: RequirementsForm) => void, error: unknown, submitted: boolean }} props */
export function RequirementsFields({ form, onChange, error, submitted }) {
  const { errors } = requirementsOf(form);
  /** Returns true if some of these figures have limits of one flank. @param {Figures} figures */
  const oneFlank = (figures) =>
    figures.some(({ name }) =>
      sidesOf(name).some(
        (side) => side !== "both" && [0, 1].some((end) => form.limits[placeOf(side, name, end ? 1 : 0)]),
      ),
    );
  const ends = (/** @type {readonly Side[]} */ sides, /** @type {Figures} */ figures) =>
    h(Limits, { sides, figures, form, error, errors: submitted ? errors : onlyNumbers(errors), onChange });
  /** @param {"class" | "pitchClass"} name @param {string} label @param {string} hint @param {string} pointer */
  const classField = (name, label, hint, pointer) =>
    h(SelectField, {
      label,
      hint,
      value: form[name] ?? "",
      error,
      pointer,
      onChange: (value) => onChange({ ...form, [name]: value }),
      options: [
        { value: "", label: t.noClass },
        ...CLASSES.map((value) => ({ value, label: html`<span translate="no">${value}</span>` })),
      ],
    });
  return html`<div class="requirements-fields">
    <div class="fields">${classField("class", t.class, t.classHint, "/requirements/tolerance_limits/class")}</div>
    <div role="group" aria-label=${t.limits}>
      <h3>${t.limits}</h3>
      <p class="hint">${t.limitsHint}</p>
      ${ends(["both"], FIGURES)}
      <details open=${oneFlank(FIGURES)}><summary>${t.oneFlank}</summary>${ends(["left", "right"], FIGURES)}</details>
    </div>
    <div role="group" aria-label=${t.design}>
      <h3>${t.design}</h3>
      <p class="hint">${t.designHint}</p>
      <div class="fields">
        ${SURFACE_FIGURES.map(({ name, symbol }) =>
          h(TextField, {
            key: name,
            label: html`${h(GearSymbol, { name: symbol })} ${t.designOf(t[name])}`,
            unit: "µm",
            numeric: true,
            value: form.design?.[name] ?? "",
            error,
            pointer: designPointer(name),
            fieldError: errors[designPlace(name)] && t.notANumber,
            onInput: (value) => onChange({ ...form, design: { ...form.design, [name]: value } }),
          }),
        )}
      </div>
    </div>
    <div role="group" aria-label=${t.pitchLimits}>
      <h3>${t.pitchLimits}</h3>
      <div class="fields">
        ${classField("pitchClass", t.pitchClass, t.pitchClassHint, "/requirements/pitch_limits/class")}
      </div>
      ${ends(["both"], PITCH_FIGURES)}
      <details open=${oneFlank(PITCH_FIGURES)}><summary>${t.pitchesOfOneFlank}</summary>
        ${ends(["left", "right"], PITCH_FIGURES.slice(0, 2))}</details>
    </div>
    <div role="group" aria-label=${t.bands}>
      <h3>${t.bands}</h3>
      ${form.bands.map((band, i) =>
        h(Band, {
          key: i,
          band,
          index: i,
          error,
          fieldError: (edge) => (submitted ? errors[bandPlace(i, edge)] : undefined),
          onChange: (next) => onChange({ ...form, bands: form.bands.map((one, k) => (k === i ? next : one)) }),
          onRemove: () => onChange({ ...form, bands: form.bands.filter((_, k) => k !== i) }),
        }),
      )}
      <div class="actions">
        <button type="button" class="button" onClick=${() => onChange({ ...form, bands: [...form.bands, emptyBand()] })}>${t.addBand}</button>
      </div>
    </div>
  </div>`;
}

/** Keeps the errors that are shown while somebody types. @param {Record<string, import("../lib/requirements.js").FieldError>} errors */
const onlyNumbers = (errors) =>
  Object.fromEntries(Object.entries(errors).filter(([, fieldError]) => fieldError === "notANumber"));

/** A table of two fields per figure, from and to. @param {{ sides: readonly Side[], figures: Figures, form: RequirementsForm, errors: Record<string, import("../lib/requirements.js").FieldError>, error: unknown, onChange: (form: RequirementsForm) => void }} props */
function Limits({ sides, figures, form, errors, error, onChange }) {
  const id = useId();
  return html`<div class="limits-grid" data-sides=${sides.length}>
    ${sides.length > 1 && html`<span></span>${sides.map((side) => html`<b key=${side} class="limits-side">${t[side]}</b>`)}`}
    ${figures.map(({ name, symbol }) => {
      const wrong = sides.flatMap((side) => {
        const pointer = limitPointer(side, name);
        const own = errors[placeOf(side, name, 0)];
        return [
          ...(own ? [html`<span key=${side}>${t[own]}</span>`] : []),
          ...errorsAt(error, pointer).map((one) => html`<span key=${one.pointer} lang="en">${one.detail}</span>`),
        ];
      });
      const fieldError = `${id}-${name}`;
      return html`<div key=${name} class="limits-row" role="group" aria-label=${t[name]}>
        <span class="limits-name">${h(GearSymbol, { name: symbol })} ${t[name]}</span>
        ${sides.map(
          (side) => html`<span key=${side} class="limits-ends" data-side=${sides.length > 1 ? t[side] : undefined}>
          ${
            /** @type {const} */ ([0, 1]).map((end) => {
              const place = placeOf(side, name, end);
              const whose = sidesOf(name).length > 1 ? [t[side]] : [];
              const label = [t[name], ...whose, end === 0 ? t.from : t.to].join(", ");
              return html`${end === 1 && html`<span class="quiet" aria-hidden="true">…</span>`}<input key=${place} type="text" class="numeric" inputmode="decimal"
              autocomplete="off" spellcheck=${false} aria-label=${label} value=${form.limits[place] ?? ""}
              aria-invalid=${wrong.length > 0 ? "true" : undefined} aria-describedby=${wrong.length > 0 ? fieldError : undefined}
              onInput=${(/** @type {Typed} */ event) => onChange({ ...form, limits: { ...form.limits, [place]: event.currentTarget.value } })} />`;
            })
          }<span class="unit" translate="no">µm</span>
        </span>`,
        )}
        ${wrong.length > 0 && html`<span class="field-error" id=${fieldError}>${wrong}</span>`}
      </div>`;
    })}
  </div>`;
}

/** @param {{ band: BandForm, index: number, error: unknown, fieldError: (edge: "upper" | "lower") => import("../lib/requirements.js").FieldError | undefined, onChange: (band: BandForm) => void, onRemove: () => void }} props */
function Band({ band, index, error, fieldError, onChange, onRemove }) {
  const text = (/** @type {"upper" | "lower"} */ edge) => {
    const wrong = fieldError(edge);
    return h(TextField, {
      key: edge,
      label: t[edge],
      hint: t.pointsHint,
      required: true,
      lines: 4,
      value: band[edge],
      error,
      pointer: `/requirements/k_bands/${index}/${edge}`,
      fieldError: wrong && t[wrong],
      onInput: (value) => onChange({ ...band, [edge]: value }),
    });
  };
  return html`<div class="band-fields" role="group" aria-label=${t.band(index + 1)}>
    <header><h4>${t.band(index + 1)}</h4>
      <button type="button" class="button small" onClick=${onRemove}>${t.removeBand(index + 1)}</button></header>
    <div class="fields">
      ${h(SelectField, {
        label: t.kind,
        required: true,
        value: band.kind,
        onChange: (kind) => onChange({ ...band, kind: /** @type {"profile"} */ (kind) }),
        options: /** @type {const} */ (["profile", "helix"]).map((value) => ({ value, label: t[value] })),
      })}
      ${h(SelectField, {
        label: t.flank,
        required: true,
        value: band.flank,
        onChange: (flank) => onChange({ ...band, flank: /** @type {""} */ (flank) }),
        options: [
          { value: "", label: t.bothFlanks },
          { value: "left", label: t.leftFlank },
          { value: "right", label: t.rightFlank },
        ],
      })}
      ${h(SelectField, {
        label: t.against,
        required: true,
        value: band.against,
        error,
        pointer: `/requirements/k_bands/${index}/against`,
        onChange: (against) => onChange({ ...band, against: /** @type {"design"} */ (against) }),
        options: /** @type {const} */ (["involute", "design"]).map((value) => ({
          value,
          label: t[`against_${value}`],
        })),
      })}
      ${
        band.kind === "profile" &&
        h(SelectField, {
          label: t.axis,
          required: true,
          value: band.axis,
          onChange: (axis) => onChange({ ...band, axis: /** @type {"diameter"} */ (axis) }),
          options: /** @type {const} */ (["roll_length", "diameter", "roll_angle"]).map((value) => ({
            value,
            label: t[value],
          })),
        })
      }
      ${text("upper")} ${text("lower")}
    </div>
  </div>`;
}
