// Form for the measurand of an iteration's nodes, added or changed after they were stored.

import { answer, api } from "../api/client.js";
import { t as common } from "../i18n/common.js";
import { texts } from "../i18n/i18n.js";
import de from "../i18n/de/iteration.js";
import en from "../i18n/en/iteration.js";
import { h, html, useState } from "../../vendor/ui.js";
import { Dialog } from "./dialog.js";
import { Checkbox, SelectField, TextField } from "./form.js";
import { FlankField, UnitField } from "./measurand_fields.js";
import { Failure } from "./states.js";
import { notify } from "./toast.js";

const t = texts({ en, de });

/** @typedef {import("../api/client.js").Schema<"Iteration">} Iteration */
/** @typedef {import("../api/client.js").Schema<"Axes">} Axes */

const POINTERS = ["/flank", "/tooth", "/axes/u", "/axes/z/unit"];

/** Returns true if nodes may be on a flank: their axes are those of a surface, or not described. @param {Axes | null | undefined} axes */
export const mayBeFlank = (axes) => !axes?.x && !axes?.y;

/** Returns the quantity of the first abscissa; "" for a word of the caller's own. @param {Axes | null | undefined} axes */
function alongOf(axes) {
  const quantity = axes?.u?.quantity;
  if (quantity === undefined) return "roll_length";
  return quantity === "roll_length" || quantity === "diameter" ? quantity : "";
}

/**
 * @param {{ iteration: Iteration, etag: string | undefined, put: (iteration: Iteration, etag: string | undefined) => void,
 *   onClose: () => void }} props
 */
export function EditMeasurand({ iteration, etag, put, onClose }) {
  const { axes } = iteration;
  const [flank, setFlank] = useState(/** @type {string} */ (iteration.flank ?? ""));
  const [tooth, setTooth] = useState(iteration.tooth ?? "");
  const [along, setAlong] = useState(/** @type {string} */ (alongOf(axes)));
  const [unit, setUnit] = useState(axes?.z?.unit ?? "um");
  const [accepted, setAccepted] = useState(iteration.accept_units === true);
  const [error, setError] = useState(/** @type {unknown} */ (undefined));
  const [sending, setSending] = useState(false);
  const send = async (/** @type {Event} */ event) => {
    event.preventDefault();
    setSending(true);
    const mm = (/** @type {string} */ quantity) => ({ quantity, unit: "mm" });
    const given = {
      ...(along !== "" && along !== axes?.u?.quantity && { u: mm(along) }),
      ...(!axes?.v && { v: mm("face_width") }),
      ...(unit !== axes?.z?.unit && { z: { quantity: "deviation", ...axes?.z, unit } }),
    };
    const body = {
      ...(flank !== "" && flank !== iteration.flank && { flank: /** @type {"left" | "right"} */ (flank) }),
      ...(tooth.trim() !== "" && tooth.trim() !== iteration.tooth && { tooth: tooth.trim() }),
      ...(Object.keys(given).length > 0 && { axes: given }),
      ...(accepted !== (iteration.accept_units === true) && { accept_units: accepted }),
    };
    if (Object.keys(body).length === 0) {
      onClose();
      return;
    }
    try {
      const path = { job_id: iteration.job_id, number: iteration.number };
      const header = etag ? { "If-Match": etag } : {};
      const done = await answer(api.PATCH("/v1/jobs/{job_id}/iterations/{number}", { params: { path, header }, body }));
      put(done.data, done.etag);
      notify(t.measurandStored);
      onClose();
    } catch (caught) {
      setError(caught);
      setSending(false);
    }
  };
  return h(Dialog, {
    title: t.editMeasurand,
    onClose,
    children: html`<form onSubmit=${send}>
      <div class="fields">
        ${h(FlankField, { value: flank, onChange: setFlank, none: iteration.flank ? undefined : t.notSaid, error, pointer: "/flank" })}
        ${h(TextField, { label: t.tooth, value: tooth, onInput: setTooth, maxLength: 200, error, pointer: "/tooth" })}
        ${h(SelectField, {
          label: t.along,
          required: true,
          value: along,
          options: [
            ...(along === "" ? [{ value: "", label: axes?.u?.quantity ?? "" }] : []),
            { value: "roll_length", label: t.rollLength },
            { value: "diameter", label: t.diameter },
          ],
          onChange: setAlong,
          error,
          pointer: "/axes/u",
        })}
        ${h(UnitField, { value: unit, onChange: setUnit, error, pointer: "/axes/z/unit" })}
      </div>
      ${h(Checkbox, { label: t.acceptUnits, checked: accepted, onChange: setAccepted })}
      <p class="hint">${t.measurandHint}</p>
      ${error !== undefined && h(Failure, { error, except: POINTERS })}
      <div class="actions end">
        <button type="button" class="button" onClick=${onClose}>${common.cancel}</button>
        <button type="submit" class="button primary" disabled=${sending}>${t.storeMeasurand}</button>
      </div>
    </form>`,
  });
}
