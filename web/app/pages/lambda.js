// The choice of λ*: its effect, the choices of the criteria, a manual refit, and the chosen fit.

import { useAttempt } from "../api/attempt.js";
import { answer, api } from "../api/client.js";
import { may } from "../api/key.js";
import { useLatest } from "../api/latest.js";
import { useResource } from "../api/resource.js";
import { useWatched } from "../api/watched.js";
import { Badge, Facts } from "../components/figure.js";
import { JobPage } from "../components/job_page.js";
import { ReasonDialog } from "../components/reason_dialog.js";
import { Failure, loaded } from "../components/states.js";
import { notify } from "../components/toast.js";
import de from "../i18n/de/lambda.js";
import en from "../i18n/en/lambda.js";
import { t as common } from "../i18n/common.js";
import { fmt, texts } from "../i18n/i18n.js";
import { kept, useFit, useNodes } from "../flank/use_layers.js";
import { useLeaving } from "../lib/leaving.js";
import { heightUnit } from "../lib/units.js";
import { query, setQuery } from "../navigation.js";
import { Choices } from "../regularization/choices.js";
import { Coefficients, FilterFactors } from "../regularization/coefficients.js";
import { Curves } from "../regularization/curves.js";
import { Fits } from "../regularization/fits.js";
import { RidgeTrace } from "../regularization/ridge_trace.js";
import { countsRank, movable, queryOf, rangeOf, refitOf, selectionOf, symbolOf } from "../regularization/selection.js";
import { FOLLOWED, includedFor, RefitMap, shownLayer } from "../regularization/map.js";
import { LambdaSlider } from "../regularization/slider.js";
import { h, html, useEffect, useRef, useState } from "../../vendor/ui.js";

/** @typedef {import("../api/client.js").Schema<"Iteration">} Iteration */
/** @typedef {import("../api/client.js").Schema<"IterationFit">} IterationFit */
/** @typedef {import("../regularization/selection.js").Selection} Selection */

export const styles = ["lambda"];
const t = texts({ en, de });

/** @param {{ params: Record<string, string> }} props */
export default function Lambda({ params }) {
  const path = { job_id: params["job_id"] ?? "", number: Number(params["number"]) };
  const iteration = useResource(`iteration ${path.job_id} ${path.number}`, (signal) =>
    answer(api.GET("/v1/jobs/{job_id}/iterations/{number}", { signal, params: { path } })),
  );
  return h(JobPage, {
    jobId: path.job_id,
    view: `${common.lambda} ${common.iteration(path.number)}`,
    number: path.number,
    onEvents: iteration.reload,
    children: (job) =>
      loaded({
        resource: iteration,
        lines: 14,
        children: (data) =>
          h(OfFit, {
            key: `${path.job_id} ${path.number}`,
            iteration: data,
            flipU: job.gear?.internal === true,
            etag: iteration.etag,
            onChosen: iteration.put,
            reload: iteration.reload,
          }),
      }),
  });
}

/**
 * @param {{ iteration: Iteration, flipU: boolean, etag: string | undefined, onChosen: (iteration: Iteration, etag: string | undefined) => void, reload: () => void }} props
 */
function OfFit({ iteration, flipU, etag, onChosen, reload }) {
  const chosenFit = iteration.fits.find(({ chosen }) => chosen);
  const id = query.value.get("fit") ?? chosenFit?.id ?? "";
  const path = { job_id: iteration.job_id, number: iteration.number };
  const get = (/** @type {string} */ fit_id, /** @type {AbortSignal} */ signal) =>
    answer(
      api.GET("/v1/jobs/{job_id}/iterations/{number}/fits/{fit_id}", {
        signal,
        params: { path: { ...path, fit_id }, query: { include: ["lambda_curve", "ridge_trace"] } },
      }),
    );
  const fit = useResource(id ? `curve ${id}` : null, (signal) => get(id, signal));
  const unit = heightUnit(iteration.axes) ?? common.callersUnit;
  // content below comes after the fit, so that nothing jumps, and stays while another fit is
  // loading
  const settledOnce = useRef(false);
  settledOnce.current ||= fit.data !== undefined || fit.error !== undefined;
  return html`<div class="lambda-page">
    <div><h2>${t.title}</h2><p class="quiet">${t.about}</p></div>
    ${loaded({
      resource: fit,
      lines: 14,
      children: (data) =>
        h(Choosing, { key: id, iteration, flipU, fit: data, unit, chosenLambda: chosenFit?.lambda_star, reload }),
    })}
    ${settledOnce.current && h(Fits, { iteration, etag, viewed: id, unit, onChosen })}
  </div>`;
}

/** @param {{ iteration: Iteration, flipU: boolean, fit: IterationFit, unit: string | undefined, chosenLambda: number | undefined, reload: () => void }} props */
function Choosing({ iteration, flipU, fit, unit, chosenLambda, reload }) {
  const { spec, result } = fit;
  const path = { job_id: iteration.job_id, number: iteration.number };
  const [selection, setSelection] = useState(() => selectionOf(query.value));
  const [settled, setSettled] = useState(selection);
  const show = (/** @type {Selection | undefined} */ next, rests = true) => {
    setSelection(next);
    if (rests) setSettled(next);
  };
  const [keeping, setKeeping] = useState(false);
  const watched = useWatched();
  const attempt = useAttempt(`fit ${path.job_id} ${path.number}`);
  const leaving = useLeaving();
  const nodes = useNodes(path.job_id, path.number);
  const measured = nodes.data && kept(nodes.data);
  // while nodes are loading, the axes of the fit decide if there will be a map
  const mapped =
    nodes.data === undefined ? nodes.error === undefined && Boolean(result.domain?.v) : measured !== undefined;
  const many = iteration.node_count > FOLLOWED;
  const include = measured ? includedFor(shownLayer()) : [];
  const ask = async (
    /** @type {import("../regularization/selection.js").PreviewRequest} */ body,
    /** @type {AbortSignal} */ signal,
  ) => {
    const pending = api.POST("/v1/jobs/{job_id}/iterations/{number}/preview", { signal, params: { path }, body });
    return (await answer(pending)).data;
  };
  const preview = useLatest(selection && refitOf(spec, selection, many ? [] : include), ask);
  const followed = useLatest(many && measured && settled ? refitOf(spec, settled, include) : undefined, ask);
  const stored = useFit(path.job_id, path.number, measured && !selection ? fit.id : undefined, include);
  // the address follows the result: moves are many
  useEffect(() => {
    if (preview.current) setQuery(queryOf(selection));
  }, [preview.current, selection]);
  const refit = selection ? preview.data : undefined;
  const shown = refit ?? result;
  const drawn = selection ? (many ? followed.data : refit) : stored.data?.result;
  const symbol = symbolOf(spec);
  const range = rangeOf(spec, result);
  const ranks = countsRank(spec);
  const chosen =
    selection && "value" in selection
      ? selection.value
      : ranks
        ? shown.regularization.rank
        : shown.regularization.lambda_star;
  const keep = async (/** @type {string} */ reason) => {
    if (!selection) return;
    const body = { ...refitOf(spec, selection), ...(reason ? { reason } : {}) };
    const key = attempt.headers(body);
    const { data } = await watched.run(
      (how) => api.POST("/v1/jobs/{job_id}/iterations/{number}/fits", { ...how, params: { path, header: key }, body }),
      leaving,
    );
    attempt.done();
    notify(t.kept);
    if (leaving.aborted) return;
    setQuery({ fit: data.id, by: undefined, lambda: undefined }, { step: true });
    reload();
  };
  const shownBy = selection && "by" in selection ? selection.by : undefined;
  return html`
    <div class="lambda-top">
      <section class="panel lambda-shown" aria-labelledby="lambda-shown">
        <header><h2 id="lambda-shown">${selection ? t.refit : fit.chosen ? t.chosenFit : t.storedFit}</h2>
          ${selection ? h(Badge, { kind: "warn", children: t.notStored }) : fit.chosen ? h(Badge, { kind: "good", children: t.chosen }) : null}</header>
        ${h(Facts, { items: factsOf(shown, symbol, unit) })}
        ${preview.error !== undefined && selection && preview.current && h(Failure, { error: preview.error })}
        ${!may("compute") ? null : range && movable(spec) ? h(LambdaSlider, { range, value: chosen, symbol, ranks, onMove: (value, rests) => show({ value }, rests) }) : html`<p class="note">${t.nothingToMove}</p>`}
        <div class="actions">
          ${may("decide") && html`<button type="button" class="button primary" disabled=${!selection || !preview.current || preview.error !== undefined} onClick=${() => setKeeping(true)}>${t.keep}</button>`}
          <button type="button" class="button" disabled=${!selection} onClick=${() => show(undefined)}>${t.back}</button>
        </div>
      </section>
      ${h(FilterFactors, { result: shown, symbol })}
    </div>
    ${mapped && h(RefitMap, { measured, residuals: drawn?.residuals, axes: iteration.axes, flipU, refit: selection !== undefined, many })}
    ${result.lambda_curve && h(Curves, { curve: result.lambda_curve, result, chosenLambda, shown: selection && chosen, symbol, unit, onPick: (value) => show({ value }) })}
    ${result.ridge_trace && h(RidgeTrace, { points: result.ridge_trace, result, at: chosen })}
    ${h(Choices, { choices: result.regularization.choices, symbol, unit, chosenBy: fit.chosen ? result.regularization.criterion : undefined, shownBy, onShow: (by) => show({ by }) })}
    ${h(Coefficients, { before: result, after: shown, axes: iteration.axes, afterName: t.refit, names: "coefficients" })}
    ${keeping && h(ReasonDialog, { title: t.keepTitle, text: t.keepText, label: t.reason, action: t.keep, required: true, draft: `keep ${path.job_id} ${path.number}`, watched, send: keep, onClose: () => setKeeping(false) })}
  `;
}

/** @param {IterationFit["result"]} result @param {string} symbol @param {string | undefined} unit */
function factsOf(result, symbol, unit) {
  const { regularization, spectrum, residuals, bias } = result;
  const data = (/** @type {string} */ text) => html`<span translate="no">${text}</span>`;
  const found = regularization.choices.find(({ criterion }) => criterion === regularization.criterion);
  return [
    ...(regularization.rank === undefined
      ? [{ name: t.symbol(symbol), value: data(fmt.value.three(regularization.lambda_star)) }]
      : [{ name: t.rank, value: data(fmt.value.count(regularization.rank)) }]),
    { name: t.rms, value: data(`${fmt.value.three(residuals.rms)}${unit ? ` ${unit}` : ""}`) },
    { name: t.condition, value: data(fmt.value.condition(spectrum.regularized.condition)) },
    { name: t.predictedMse, value: data(fmt.value.three(found?.predicted_mse)) },
    { name: t.biasNorm, value: data(fmt.value.three(bias.norm)) },
    { name: t.directions, value: data(regularization.count === undefined ? "–" : `${regularization.count}`) },
  ];
}
