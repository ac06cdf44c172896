// The fields of a measurand: flank, quantities along u and v, unit of the heights; and their
// meaning in words.

import de from "../i18n/de/measure.js";
import en from "../i18n/en/measure.js";
import { fmt, texts } from "../i18n/i18n.js";
import { inWords } from "../measure/likely.js";
import { h } from "../../vendor/ui.js";
import { SelectField } from "./form.js";

const t = texts({ en, de });

/**
 * @typedef {{ value: string, onChange: (value: string) => void, error?: unknown, pointer?: string }} Choice
 * @typedef {"roll_length" | "diameter"} Along
 */

/** @param {Choice & { none: string | undefined }} props `none`: word of no flank, where none may be chosen */
export function FlankField({ none, ...props }) {
  const options = [
    ...(none === undefined ? [] : [{ value: "", label: none }]),
    { value: "left", label: t.left },
    { value: "right", label: t.right },
  ];
  return h(SelectField, { label: t.flank, required: true, options, ...props });
}

/** Axes of a table without named columns. @param {Choice} props */
export function AxesField(props) {
  const options = [
    { value: "none", label: t.axesNone },
    { value: "roll_length", label: t.axesRoll },
    { value: "diameter", label: t.axesDiameter },
  ];
  return h(SelectField, { label: t.axes, hint: t.axesHint, required: true, options, ...props });
}

/** @param {Choice} props a unit of the caller's own is offered too, while it is chosen */
export function UnitField(props) {
  const units = ["mm", "um", "nm", "in"];
  const options = (units.includes(props.value) ? units : [props.value, ...units]).map((value) => ({
    value,
    label: value === "in" ? t.inches : value === "um" ? "µm" : value,
    verbatim: value !== "in",
  }));
  return h(SelectField, { label: t.unitOfDeviations, required: true, options, ...props });
}

/**
 * Describes the meaning of the chosen values.
 * @param {import("../flank/surface.js").FlankSurface | undefined} surface @param {{ axes: string, unit: string }} chosen
 */
export function measurandInWords(surface, { axes, unit }) {
  const words =
    axes === "none" ? undefined : inWords(surface, /** @type {import("../measure/likely.js").Unit} */ (unit || "um"));
  if (!words) return undefined;
  const range = [words.from, words.to].map(fmt.value.three).join("–");
  return t.inWords(fmt.value.three(words.greatest), t[/** @type {"along_diameter"} */ (`along_${axes}`)], range);
}
