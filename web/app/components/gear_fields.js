// The fields of a gear, and its derived quantities.

import { answer, api } from "../api/client.js";
import { useResource } from "../api/resource.js";
import de from "../i18n/de/new_job.js";
import en from "../i18n/en/new_job.js";
import { fmt, texts } from "../i18n/i18n.js";
import { ABSENT } from "../lib/format.js";
import { FIELDS, formOf, gearOf } from "../lib/gear_form.js";
import { WarningList } from "./warnings.js";
import { Fragment, h, html, useEffect, useState } from "../../vendor/ui.js";
import { Facts } from "./figure.js";
import { SelectField, TextField } from "./form.js";
import { GearSymbol } from "./symbol.js";
import { loaded } from "./states.js";

/** @typedef {import("../lib/gear_form.js").GearForm} GearForm */
/** @typedef {import("../api/client.js").Schema<"GearGeometry">} GearGeometry */

const t = texts({ en, de });

/** Fields that most gears leave empty: folded until one of them has a value. */
const FOLDED = /** @type {const} */ ([
  "tip_diameter_mm",
  "root_diameter_mm",
  "hand",
  "tip_radius_mm",
  "addendum_factor",
  "protuberance_mm",
]);

/** An empty form. */
export const emptyGear = () => formOf(undefined, String);

/**
 * @param {{ form: GearForm, onChange: (form: GearForm) => void, error: unknown, at: string, submitted: boolean }} props
 *   `at`: the JSON Pointer of the gear in the request; `submitted`: what is missing is said
 */
export function GearFields({ form, onChange, error, at, submitted }) {
  const { errors = {} } = gearOf(form);
  const set = (/** @type {keyof GearForm} */ name) => (/** @type {string} */ value) =>
    onChange({ ...form, [name]: value });
  /** @param {keyof typeof FIELDS} name @param {import("../../vendor/ui.js").ComponentChildren} label @param {{ unit?: string, hint?: string }} [more] */
  const number = (name, label, more = {}) => {
    const fieldError = errors[name];
    return h(TextField, {
      key: name,
      label,
      value: form[name],
      onInput: set(name),
      numeric: true,
      required: "required" in FIELDS[name],
      error,
      pointer: at + FIELDS[name].pointer,
      fieldError: fieldError && (submitted || fieldError !== "needed") ? t[fieldError] : undefined,
      ...more,
    });
  };
  const hands = [
    { value: "", label: t.handBySign },
    { value: "right", label: t.right },
    { value: "left", label: t.left },
  ];
  const kinds = [
    { value: "", label: t.external },
    { value: "yes", label: t.internal },
  ];
  const [filled] = useState(Boolean(form.internal) || FOLDED.some((name) => form[name] !== ""));
  return html`<div class="fields thirds">
      ${number("teeth", named(t.teeth, "z"))} ${number("normal_module_mm", named(t.module, "m_n"), { unit: "mm" })}
      ${number("normal_pressure_angle_deg", named(t.pressure, "α_n"), { unit: "°", hint: t.pressureHint })}
      ${number("helix_angle_deg", named(t.helix, "β"), { unit: "°", hint: t.helixHint })}
      ${number("profile_shift_coefficient", named(t.shift, "x"))} ${number("face_width_mm", named(t.width, "b"), { unit: "mm" })}
    </div>
    <details open=${filled}>
      <summary>${t.more}</summary>
      <div class="fields">
        ${h(SelectField, { label: t.kind, required: true, value: form.internal, onChange: set("internal"), options: kinds })}
        ${number("tip_diameter_mm", named(t.tip, "d_a"), { unit: "mm" })} ${number("root_diameter_mm", named(t.root, "d_f"), { unit: "mm" })}
        ${h(SelectField, { label: t.hand, value: form.hand, onChange: set("hand"), options: hands, error, pointer: `${at}/hand` })}
      </div>
      <h3>${t.tool}</h3>
      <div class="fields">
        ${number("tip_radius_mm", t.toolRadius, { unit: "mm" })} ${number("addendum_factor", t.toolAddendum, { unit: "mₙ" })}
        ${number("protuberance_mm", t.protuberance, { unit: "mm" })}
      </div>
    </details>`;
}

/** A name with the symbol of what it names. @param {string} text @param {string} symbol */
const named = (text, symbol) => html`${text} ${h(GearSymbol, { name: symbol })}`;

/** Quantities derived from a gear, updated as it is typed. @param {{ form: GearForm }} props */
export function Derived({ form }) {
  const { gear } = gearOf(form);
  const wanted = useRested(gear ? JSON.stringify(gear) : null);
  const geometry = useResource(wanted === null ? null : `geometry ${wanted}`, (signal) =>
    answer(api.POST("/v1/gears/geometry", { signal, body: { gear: JSON.parse(wanted ?? "null") } })),
  );
  return html`<section class="panel derived" aria-labelledby="derived">
    <h2 id="derived">${t.derived}</h2>
    ${
      wanted === null
        ? html`<p class="quiet">${t.derivedNone}</p>`
        : loaded({ resource: geometry, lines: 8, children: (data) => h(Geometry, { data }) })
    }
  </section>`;
}

/** @param {{ data: GearGeometry }} props */
function Geometry({ data }) {
  const f = fmt.value;
  const mm = (/** @type {number | null | undefined} */ value) => html`<span translate="no">${f.mm(value)} mm</span>`;
  const pair = (/** @type {readonly number[] | null | undefined} */ range) =>
    range ? html`<span translate="no">${f.mm(range[0])} … ${f.mm(range[1])} mm</span>` : ABSENT;
  const items = [
    { name: named(t.reference, "d"), value: mm(data.reference_diameter_mm) },
    { name: named(t.base, "d_b"), value: mm(data.base_diameter_mm) },
    { name: named(t.tip, "d_a"), value: mm(data.tip_diameter_mm) },
    { name: named(t.root, "d_f"), value: mm(data.root_diameter_mm) },
    { name: t.form, value: pair(data.usable_profile?.diameters_mm) },
    { name: t.rolls, value: pair(data.usable_profile?.roll_lengths_mm) },
    { name: named(t.pitch, "p_bt"), value: mm(data.transverse_base_pitch_mm) },
    { name: t.thickness, value: mm(data.tooth_thickness_mm) },
    { name: t.tipThickness, value: mm(data.tip_thickness_mm) },
    { name: named(t.depth, "h"), value: mm(data.tooth_depth_mm) },
    { name: t.undercut, value: data.undercut ? t.yes : t.no },
  ];
  return h(Fragment, null, h(Facts, { items, columns: true }), h(GearWarnings, { warnings: data.warnings }));
}

/** @param {{ warnings: readonly { code: string, message: string }[] }} props */
export function GearWarnings({ warnings }) {
  if (warnings.length === 0) return null;
  return html`<div class="note warn">
    <h3>${t.warnings}</h3>
    ${h(WarningList, { warnings })}
  </div>`;
}

/** Returns a value once it has rested for a moment, so that not every key sends a request. @template T @param {T} value */
export function useRested(value) {
  const [rested, setRested] = useState(value);
  useEffect(() => {
    const timer = setTimeout(() => setRested(value), 200);
    return () => clearTimeout(timer);
  }, [value]);
  return rested;
}
