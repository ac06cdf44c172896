// The fields next to the files: the model of the fit, and the measurement.

import { SelectField, TextField } from "../components/form.js";
import { AxesField, FlankField, UnitField } from "../components/measurand_fields.js";
import de from "../i18n/de/measure.js";
import en from "../i18n/en/measure.js";
import { texts } from "../i18n/i18n.js";
import { h, html } from "../../vendor/ui.js";

const t = texts({ en, de });

/** @typedef {import("./request.js").Typed} Typed */

/**
 * @param {{ typed: Typed, change: (change: Partial<Typed>) => void, error: unknown, wrong: Partial<Record<keyof Typed, true>>,
 *   imports: boolean, fits: boolean, fromFile: boolean, named: boolean, said: string | undefined }} props
 *   `typed`: with the most likely values filled in; `imports`, `fits`: whether some file is imported, or fitted;
 *   `fromFile`: whether a JSON file contains these fields; `named`: whether the columns of a table name the axes; `said`:
 *   the meaning of the values in words
 */
export function MeasureFields({ typed, change, error, wrong, imports, fits, fromFile, named, said }) {
  const pointer = (/** @type {string} */ name) => (imports && !fits ? `/spec/${name}` : `/${name}`);
  const text = (/** @type {keyof Typed} */ key, /** @type {string} */ label, more = {}) =>
    h(TextField, {
      label,
      value: typed[key],
      onInput: (value) => change({ [key]: value }),
      error,
      fieldError: wrong[key] && t.noNumber,
      ...more,
    });
  const chosen = (/** @type {keyof Typed} */ key) => ({
    value: typed[key],
    onChange: (/** @type {string} */ value) => change({ [key]: value }),
    error,
  });
  const select = (
    /** @type {keyof Typed} */ key,
    /** @type {string} */ label,
    /** @type {readonly [string, string][]} */ options,
    more = {},
  ) =>
    h(SelectField, {
      label,
      required: true,
      options: options.map(([value, label]) => ({ value, label })),
      ...chosen(key),
      ...more,
    });
  return html`<div class="measure-fields">
    <fieldset>
      <legend>${t.measurement}</legend>
      <div class="fields thirds">
        ${h(FlankField, { ...chosen("flank"), none: t.asFile, pointer: pointer("flank") })}
        ${text("tooth", t.tooth, { hint: t.toothHint, pointer: pointer("tooth"), maxLength: 200 })}
        ${imports && text("component", t.component, { hint: t.componentHint, pointer: pointer("component") })}
        ${fits && text("instrument", t.instrument, { pointer: "/instrument", maxLength: 200 })}
        ${fits && text("operator", t.operator, { pointer: "/operator", maxLength: 200 })}
        ${fits && text("measuredAt", t.measuredAt, { hint: t.measuredAtHint, pointer: "/measured_at", fieldError: wrong.measuredAt && t.noTime })}
        ${fits && !named && h(AxesField, { ...chosen("axes"), pointer: "/axes" })}
        ${fits && !named && typed.axes !== "none" && h(UnitField, { ...chosen("unit"), pointer: "/axes/z/unit" })}
      </div>
      ${said && html`<p class="notice" data-preview="words">${said}</p>`}
      ${text("note", t.note, { lines: 2, pointer: pointer("note"), maxLength: 4000 })}
    </fieldset>
    ${
      fits &&
      html`<fieldset>
      <legend>${t.fit}</legend>
      ${fromFile && html`<p class="hint">${t.fromFile}</p>`}
      <div class="fields thirds">
        ${select(
          "model",
          t.model,
          [
            ["second", t.second],
            ["other", t.otherDegrees],
          ],
          { pointer: "/model" },
        )}
        ${typed.model === "other" && text("degreeU", t.degreeU, { numeric: true, required: true, fieldError: wrong.degreeU && t.noDegree })}
        ${typed.model === "other" && text("degreeV", t.degreeV, { numeric: true, required: true, fieldError: wrong.degreeV && t.noDegree })}
        ${select(
          "estimator",
          t.estimator,
          [
            ["least_squares", t.leastSquares],
            ["huber", t.huber],
            ["tukey", t.tukey],
            ["least_absolute_deviations", t.leastAbsolute],
            ["least_trimmed_squares", t.leastTrimmed],
          ],
          { pointer: "/estimator" },
        )}
        ${select(
          "regularization",
          t.regularization,
          [
            ["default", t.regularizationDefault],
            ["gcv", t.byGcv],
            ["discrepancy", t.byDiscrepancy],
            ["l_curve", t.byLCurve],
            ["ridge", t.ridge],
            ["none", t.noRegularization],
          ],
          { pointer: "/regularization" },
        )}
        ${text("conditionLimit", t.conditionLimit, { numeric: true, hint: t.conditionHint, pointer: "/regularization/condition_limit" })}
        ${select(
          "hampel",
          t.hampel,
          [
            ["off", t.off],
            ["on", t.replacePeaks],
          ],
          { pointer: "/filters" },
        )}
        ${select("gaussian", t.gaussian, [
          ["off", t.off],
          ["u", t.alongProfile],
          ["v", t.alongFace],
        ])}
        ${typed.gaussian !== "off" && text("cutoff", t.cutoff, { numeric: true, required: true, hint: t.cutoffHint })}
      </div>
    </fieldset>`
    }
  </div>`;
}
