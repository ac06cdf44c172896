// Evaluates the same traces with other ranges, sign or class; the new evaluation is added to the
// first.

import { useAttempt } from "../api/attempt.js";
import { answer, api } from "../api/client.js";
import { ApiError } from "../api/problem.js";
import { t as common } from "../i18n/common.js";
import { t } from "../i18n/evaluation.js";
import { fmt } from "../i18n/i18n.js";
import { useDraft } from "../lib/draft.js";
import { parseNumber } from "../lib/format.js";
import { useLeaving } from "../lib/leaving.js";
import { CLASSES } from "../lib/requirements.js";
import { h, html, useState } from "../../vendor/ui.js";
import { SelectField, TextField } from "./form.js";
import { Failure } from "./states.js";
import { notify } from "./toast.js";

/** @typedef {import("../api/client.js").Schema<"EvaluateGear">} EvaluateGear */
/** @typedef {import("../api/client.js").Schema<"JobRecord">} JobRecord */
/** @typedef {import("../api/client.js").Schema<"EvaluationSettings">} EvaluationSettings */

const FIELDS = [
  "/evaluation/profile_diameter_range_mm",
  "/evaluation/helix_range_mm",
  "/evaluation/sign",
  "/evaluation/against",
  "/evaluation/tolerance_limits",
];

/** @param {{ jobId: string, number: number, record: string, request: EvaluateGear, settings: EvaluationSettings, designed: boolean, onDone: (id: string) => void }} props */
export function EvaluationForm({ jobId, number, record, request, settings, designed, onDone }) {
  const write = fmt.value.input;
  const [draft, setDraft, forget] = useDraft(`evaluation ${jobId} ${number} ${record}`, () => ({
    profile: [0, 1].map((i) => write(settings.profile_diameter_range_mm?.[i])),
    helix: [0, 1].map((i) => write(settings.helix_range_mm?.[i])),
    sign: String(settings.sign ?? "din"),
    against: String(settings.against ?? "involute"),
    class: String(settings.tolerance_limits?.class ?? ""),
  }));
  const [error, setError] = useState(/** @type {unknown} */ (undefined));
  const [busy, setBusy] = useState(false);
  const attempt = useAttempt(`evaluation ${jobId} ${number} ${record}`);
  const leaving = useLeaving();
  const kinds = /** @type {const} */ (["profile", "helix"]).filter((kind) =>
    request.traces.some((trace) => trace.kind === kind),
  );
  const wrong = (/** @type {string | undefined} */ text) =>
    Number.isNaN(parseNumber(text ?? "")) ? t.notNumber : undefined;
  const send = async (/** @type {Event} */ event) => {
    event.preventDefault();
    if (busy || [...draft.profile, ...draft.helix].some(wrong)) return;
    const range = (/** @type {readonly string[]} */ texts) => {
      const values = texts.map(parseNumber).filter((value) => value !== undefined);
      return values.length > 0 ? values : undefined;
    };
    const [profile, helix] = [range(draft.profile), range(draft.helix)];
    const { tolerance_limits: _, profile_diameter_range_mm: __, helix_range_mm: ___, ...own } = request.evaluation;
    // limits from the job apply to figures about the other line
    const limits = draft.against === settings.against ? request.evaluation.tolerance_limits : undefined;
    const body = {
      ...request,
      evaluation: {
        ...own,
        ...(profile ? { profile_diameter_range_mm: profile } : {}),
        ...(helix ? { helix_range_mm: helix } : {}),
        sign: /** @type {"din"} */ (draft.sign),
        against: /** @type {"involute"} */ (draft.against),
        // posted data keeps its sign, whatever the sign of the resulting slopes
        deviation_sign: settings.deviation_sign ?? "din",
        ...(draft.class && (limits || draft.class !== String(settings.tolerance_limits?.class))
          ? { tolerance_limits: { ...limits, class: Number(draft.class) } }
          : {}),
      },
    };
    setBusy(true);
    setError(undefined);
    try {
      const params = { path: { job_id: jobId, number }, header: attempt.headers(body) };
      const { data } = await answer(
        api.POST("/v1/jobs/{job_id}/iterations/{number}/evaluations", { signal: leaving, params, body }),
      );
      attempt.done();
      forget();
      notify(t.done);
      onDone(/** @type {JobRecord} */ (data).id);
    } catch (failed) {
      if (leaving.aborted) notify(common.cancelled, "news");
      else setError(failed);
    } finally {
      setBusy(false);
    }
  };
  /** @param {"profile" | "helix"} kind @param {number} i */
  const field = (kind, i) => {
    const label = kind === "profile" ? (i === 0 ? t.profileFrom : t.profileTo) : i === 0 ? t.helixFrom : t.helixTo;
    return h(TextField, {
      key: label,
      label,
      required: true,
      numeric: true,
      unit: "mm",
      value: draft[kind][i] ?? "",
      error,
      pointer: kind === "profile" ? "/evaluation/profile_diameter_range_mm" : "/evaluation/helix_range_mm",
      fieldError: wrong(draft[kind][i]),
      onInput: (text) => setDraft({ ...draft, [kind]: draft[kind].map((old, k) => (k === i ? text : old)) }),
    });
  };
  const shown = error instanceof ApiError && error.problem.errors?.length && error.errorsElsewhere(FIELDS).length === 0;
  return html`<form onSubmit=${send} novalidate>
    <div class="fields">
      ${kinds.flatMap((kind) => [field(kind, 0), field(kind, 1)])}
      ${h(SelectField, {
        label: t.signOf,
        required: true,
        value: draft.sign,
        error,
        pointer: "/evaluation/sign",
        onChange: (sign) => setDraft({ ...draft, sign }),
        options: ["din", "vdi", "as_given"].map((value) => ({ value, label: t[/** @type {"din"} */ (value)] })),
      })}
      ${
        (designed || draft.against === "design") &&
        h(SelectField, {
          label: t.against,
          required: true,
          value: draft.against,
          error,
          pointer: "/evaluation/against",
          onChange: (against) => setDraft({ ...draft, against }),
          options: /** @type {const} */ (["involute", "design"]).map((value) => ({
            value,
            label: t[`against_${value}`],
          })),
        })
      }
      ${h(SelectField, {
        label: t.limitsClass,
        required: true,
        value: draft.class,
        error,
        pointer: "/evaluation/tolerance_limits",
        onChange: (of) => setDraft({ ...draft, class: of }),
        options: [
          { value: "", label: t.noClass },
          ...CLASSES.map((value) => ({ value, label: html`<span translate="no">${value}</span>` })),
        ],
      })}
    </div>
    ${error !== undefined && !shown && h(Failure, { error, except: FIELDS })}
    <div class="actions">
      <button type="submit" class="button primary" aria-disabled=${busy ? "true" : undefined}>${busy ? t.evaluating : t.evaluate}</button>
    </div>
  </form>`;
}
