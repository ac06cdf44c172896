// The form of a correction. The input stays, whatever the result of the request.

import { useAttempt } from "../api/attempt.js";
import { answer, api } from "../api/client.js";
import { ApiError, errorsAt } from "../api/problem.js";
import { t as words } from "../i18n/common.js";
import { t } from "../i18n/correction.js";
import { fmt } from "../i18n/i18n.js";
import { draftOf, emptyDraft, escaped, limitOf, requestOf, settingsOf } from "../lib/correction.js";
import { useDraft } from "../lib/draft.js";
import { h, html, useEffect, useRef, useState } from "../../vendor/ui.js";
import { settingName } from "./correction_result.js";
import { Checkbox, SelectField, TextField } from "./form.js";
import { Failure } from "./states.js";
import { notify } from "./toast.js";

/** @typedef {import("../lib/correction.js").Draft} Draft */
/** @typedef {import("../lib/correction.js").LimitDraft} LimitDraft */
/** @typedef {import("../api/client.js").Schema<"CorrectionRequest">} CorrectionRequest */

/** Pointers of errors that are shown at fields. */
const AT_FIELDS = [
  "/sensitivity",
  "/noise_sigma_um",
  "/response_uncertainty",
  "/absolute",
  "/target",
  "/settings_used",
];

/**
 * @param {{ jobId: string, number: number, nodeCount: number, hasGear: boolean, last: CorrectionRequest | undefined, onDone: () => void }} props
 *   `last`: the request to begin from
 */
export function CorrectionForm({ jobId, number, nodeCount, hasGear, last, onDone }) {
  const [draft, setDraft, forget] = useDraft(`correction ${jobId} ${number}`, () =>
    last ? draftOf(last, fmt.value.input) : emptyDraft(hasGear),
  );
  const [error, setError] = useState(/** @type {unknown} */ (undefined));
  const [busy, setBusy] = useState(false);
  const [shown, setShown] = useState(/** @type {Record<string, "number" | "row">} */ ({}));
  const attempt = useAttempt(`correction ${jobId} ${number}`);
  const underway = useRef(/** @type {AbortController | undefined} */ (undefined));
  useEffect(() => () => underway.current?.abort(), []);
  const change = (/** @type {Partial<Draft>} */ part) => setDraft({ ...draft, ...part });
  const fieldError = (/** @type {string} */ pointer) =>
    shown[pointer] === undefined ? undefined : shown[pointer] === "row" ? t.notRow : t.notNumber;

  const send = async (/** @type {Event} */ event) => {
    event.preventDefault();
    if (busy) return;
    const { request, errors } = requestOf(draft);
    setShown(errors);
    setError(undefined);
    if (Object.keys(errors).length > 0) {
      notify(t.lookAgain, "failed");
      return;
    }
    setBusy(true);
    underway.current = new AbortController();
    const { signal } = underway.current;
    try {
      const params = { path: { job_id: jobId, number }, header: attempt.headers(request) };
      await answer(api.POST("/v1/jobs/{job_id}/iterations/{number}/correction", { signal, params, body: request }));
      attempt.done();
      forget();
      notify(t.done);
      onDone();
    } catch (failed) {
      if (signal.aborted) notify(t.stopped, "news");
      else setError(failed);
    } finally {
      setBusy(false);
    }
  };
  const common = { error };
  const settings = settingsOf(draft);
  const known = [...AT_FIELDS, ...settings.map(({ name }) => `/limits/${escaped(name)}`)];
  const atFields =
    error instanceof ApiError && error.problem.errors?.length && error.errorsElsewhere(known).length === 0;
  return html`<form onSubmit=${send} novalidate>
    <div class="fields thirds">
      ${h(SelectField, {
        ...common,
        label: t.by,
        hint: draft.by !== "matrix" && !hasGear ? t.needsGear : t.byHint,
        required: true,
        value: draft.by,
        pointer: "/sensitivity/machine",
        onChange: (by) => change({ by: /** @type {Draft["by"]} */ (by) }),
        options: ["form_grinding", "generating_grinding", "matrix"].map((value) => ({
          value,
          label: t[/** @type {"matrix"} */ (value)],
        })),
      })}
      ${
        draft.by !== "matrix" &&
        h(SelectField, {
          ...common,
          label: t.flank,
          required: true,
          value: draft.flank,
          pointer: "/sensitivity/flank",
          onChange: (flank) => change({ flank: /** @type {Draft["flank"]} */ (flank) }),
          options: [
            { value: "", label: t.ofIteration },
            { value: "left", label: t.left },
            { value: "right", label: t.right },
          ],
        })
      }
      ${
        draft.by !== "matrix" &&
        h(SelectField, {
          ...common,
          label: t.axis,
          required: true,
          value: draft.axis,
          pointer: "/sensitivity/profile_axis",
          onChange: (axis) => change({ axis: /** @type {Draft["axis"]} */ (axis) }),
          options: [
            { value: "", label: t.ofIteration },
            ...["roll_length", "roll_angle", "diameter"].map((value) => ({
              value,
              label: t[/** @type {"diameter"} */ (value)],
            })),
          ],
        })
      }
      ${h(TextField, {
        ...common,
        label: t.noise,
        hint: t.noiseHint,
        unit: "µm",
        numeric: true,
        value: draft.noise,
        pointer: "/noise_sigma_um",
        fieldError: fieldError("/noise_sigma_um"),
        onInput: (noise) => change({ noise }),
      })}
      ${h(TextField, {
        ...common,
        label: t.response,
        hint: t.responseHint,
        numeric: true,
        value: draft.response,
        pointer: "/response_uncertainty",
        fieldError: fieldError("/response_uncertainty"),
        onInput: (response) => change({ response }),
      })}
      ${h(SelectField, {
        ...common,
        label: t.absolute,
        required: true,
        value: draft.absolute,
        pointer: "/absolute",
        onChange: (absolute) => change({ absolute: /** @type {Draft["absolute"]} */ (absolute) }),
        options: [
          { value: "", label: t.byDefault },
          { value: "true", label: t.yes },
          { value: "false", label: t.no },
        ],
      })}
      ${h(SelectField, {
        ...common,
        label: t.target,
        hint: t.targetAbout,
        required: true,
        value: draft.aim,
        pointer: "/target",
        onChange: (aim) => change({ aim: /** @type {Draft["aim"]} */ (aim) }),
        options: [
          { value: "", label: t.targetOfJob },
          ...["design", "limits", "nominal", "given"].map((value) => ({
            value,
            label: t[/** @type {"target_design"} */ (`target_${value}`)],
          })),
        ],
      })}
      ${h(SelectField, {
        ...common,
        label: t.used,
        hint: t.usedHint,
        required: true,
        value: draft.used,
        pointer: "/settings_used",
        onChange: (used) => change({ used: /** @type {Draft["used"]} */ (used) }),
        options: [
          { value: "", label: t.byDefault },
          { value: "needed", label: t.usedNeeded },
          { value: "all", label: t.usedAll },
        ],
      })}
    </div>
    ${
      draft.by === "matrix" &&
      h(TextField, {
        ...common,
        label: t.matrixField,
        hint: t.matrixHint(nodeCount),
        required: true,
        lines: 8,
        value: draft.matrix,
        pointer: "/sensitivity",
        fieldError: fieldError("/sensitivity/matrix"),
        onInput: (matrix) => change({ matrix }),
      })
    }
    <fieldset>
      <legend>${t.limits}</legend>
      <p class="quiet">${settings.length > 0 ? t.limitsAbout : t.noSettings}</p>
      ${settings.map(({ name, unit }) =>
        h(Limits, {
          key: name,
          name,
          unit,
          limit: limitOf(draft, name),
          error,
          fieldError,
          onChange: (limit) => change({ limits: { ...draft.limits, [name]: limit } }),
        }),
      )}
    </fieldset>
    ${
      draft.aim === "given" &&
      h(TextField, {
        ...common,
        label: t.wanted,
        hint: t.wantedHint(nodeCount),
        required: true,
        unit: "µm",
        lines: 2,
        value: draft.target,
        pointer: "/target/deviation_um",
        fieldError: fieldError("/target"),
        onInput: (target) => change({ target }),
      })
    }
    ${error !== undefined && !atFields && h(Failure, { error, except: known })}
    <div class="actions">
      <button type="submit" class="button primary" aria-disabled=${busy ? "true" : undefined}>${busy ? t.computing : t.compute}</button>
      ${busy && html`<button type="button" class="button" onClick=${() => underway.current?.abort()}>${words.cancel}</button>`}
      ${busy && html`<progress aria-label=${t.computing}></progress>`}
    </div>
  </form>`;
}

/**
 * @param {{ name: string, unit: string | undefined, limit: LimitDraft, error: unknown,
 *   fieldError: (pointer: string) => string | undefined, onChange: (limit: LimitDraft) => void }} props
 */
function Limits({ name, unit, limit, error, fieldError, onChange }) {
  const at = `/limits/${escaped(name)}`;
  const own = errorsAt(error, at).filter(({ pointer }) => pointer === at || pointer === `${at}/fixed`);
  /** @param {"min" | "max" | "increment"} key @param {string} label */
  const field = (key, label) =>
    h(TextField, {
      label,
      required: true,
      numeric: true,
      ...(unit ? { unit } : {}),
      value: limit[key],
      error,
      pointer: `${at}/${key}`,
      fieldError: fieldError(`${at}/${key}`),
      onInput: (value) => onChange({ ...limit, [key]: value }),
    });
  return html`<div class="limits" role="group" aria-label=${settingName(name)}>
    <p class="limits-name"><b translate=${settingName(name) === name ? "no" : undefined}>${settingName(name)}</b></p>
    ${h(Checkbox, { label: t.fix, checked: limit.fixed, onChange: (fixed) => onChange({ ...limit, fixed }) })}
    ${!limit.fixed && field("min", t.min)}${!limit.fixed && field("max", t.max)}${!limit.fixed && field("increment", t.step)}
    ${own.length > 0 && html`<p class="field-error">${own.map((one) => html`<span key=${one.pointer} lang="en">${one.detail}</span>`)}</p>`}
  </div>`;
}
