// The flank map of an iteration: its layers, sections, figures, and the decision.

import { answer, api } from "../api/client.js";
import { may } from "../api/key.js";
import { useResource } from "../api/resource.js";
import { Decision } from "../components/decision.js";
import { EditMeasurand, mayBeFlank } from "../components/edit_measurand.js";
import { FigureTiles } from "../components/figure_tiles.js";
import { FlankFigures } from "../components/flank_figures.js";
import { JobPage } from "../components/job_page.js";
import { PitchInShort, usePitch } from "../components/pitch_in_short.js";
import { Empty, loaded } from "../components/states.js";
import { AllTeeth } from "../flank/all_teeth.js";
import { FlankCurve } from "../flank/curve.js";
import { columnsOf, NodeAction, Suspects, useExclusion } from "../flank/exclude.js";
import { FitCoefficients, FitFigures, Warnings } from "../flank/figures.js";
import { hasDatum } from "../flank/layers.js";
import { FlankView } from "../flank/view.js";
import { LAYERS, useFit, useJobLimit, useLayer, useNodes } from "../flank/use_layers.js";
import { marksOf } from "../lib/exclude.js";
import { heightUnit, micrometres } from "../lib/units.js";
import { t as common } from "../i18n/common.js";
import { t as correctionText } from "../i18n/correction.js";
import de from "../i18n/de/iteration.js";
import en from "../i18n/en/iteration.js";
import { fmt, texts } from "../i18n/i18n.js";
import { query, setQuery } from "../navigation.js";
import { Facts } from "../components/figure.js";
import { SelectField } from "../components/form.js";
import { Failure, Skeleton } from "../components/states.js";
import { Fragment, h, html, useCallback, useLayoutEffect, useRef, useState } from "../../vendor/ui.js";

/** @typedef {import("../api/client.js").Schema<"Iteration">} Iteration */
/** @typedef {import("../api/client.js").Schema<"TracedIteration">} TracedIteration */
/** @typedef {import("../api/job.js").Job} Job */

const t = texts({ en, de });
export const styles = ["iteration"];

/** Layers whose data the trace announces. */
const OF_TRACE = /** @type {readonly string[]} */ (["difference", "predicted", "answered", "teeth"]);

/** @param {{ params: Record<string, string> }} props */
export default function IterationPage({ params }) {
  const jobId = params["job_id"] ?? "";
  const number = Number(params["number"]);
  const iteration = useResource(`iteration ${jobId} ${number}`, (signal) =>
    answer(api.GET("/v1/jobs/{job_id}/iterations/{number}", { signal, params: { path: { job_id: jobId, number } } })),
  );
  return h(JobPage, {
    jobId,
    number,
    view: common.iteration(number),
    onEvents: iteration.reload,
    children: (job, { trace }) =>
      loaded({
        resource: iteration,
        lines: 12,
        children: (data) =>
          h(Whole, {
            job,
            iteration: data,
            traced: trace.data?.iterations ?? [],
            traceSettled: trace.data !== undefined || trace.error !== undefined,
            resource: iteration,
            reread: trace.reload,
          }),
      }),
  });
}

/**
 * The page. Content below something that is loading comes after it, so that nothing jumps.
 * @param {{ job: Job, iteration: Iteration, traced: readonly TracedIteration[], traceSettled: boolean, reread: () => void,
 *   resource: import("../api/resource.js").Resource<Iteration> }} props `traceSettled`: the trace is there
 */
function Whole({ job, iteration, traced, traceSettled, resource, reread }) {
  const fit = iteration.fits.find(({ chosen }) => chosen);
  const chosen = useFit(job.id, iteration.number, fit?.id);
  const own = traced.find(({ number }) => number === iteration.number);
  const decided = own?.decisions.at(-1);
  const pitch = usePitch(job.id, iteration.number, own?.records ?? []);
  const [mapped, setMapped] = useState(false);
  const onMapped = useCallback(() => setMapped(true), []);
  const put = (/** @type {Iteration} */ data, /** @type {string | undefined} */ etag) => {
    resource.put(data, etag);
    reread();
  };
  const columns = columnsOf(useNodes(job.id, iteration.number).data);
  const exclusion = useExclusion({ iteration, fit: chosen.data, columns, onChosen: put });
  return html`<div class="flank-page">
    <div class="flank-main">${h(FigureTiles, { figures: fit?.figures })}${h(Layers, { job, iteration, traced, traceSettled, fitId: fit?.id, chosen: chosen.data, exclusion, onMapped })}</div>
    <div class="flank-aside">
      ${h(Decision, {
        iteration,
        etag: resource.etag,
        reason: decided?.decision === iteration.decision ? decided?.reason : undefined,
        reload: resource.reload,
        put,
      })}
      ${
        traceSettled
          ? loaded({
              resource: chosen,
              lines: 8,
              children: (data) =>
                h(
                  Fragment,
                  null,
                  h(FitFigures, { result: data.result, axes: iteration.axes }),
                  h(Suspects, { exclusion, fit: data, unit: heightUnit(iteration.axes) }),
                  h(Warnings, { result: data.result }),
                ),
            })
          : h(Skeleton, { lines: 8 })
      }
      ${traceSettled && settled(chosen) && pitch && h(PitchInShort, { jobId: job.id, number: iteration.number, pitch })}
      ${
        traceSettled &&
        settled(chosen) &&
        (!pitch || settled(pitch)) &&
        h(Measured, {
          iteration,
          etag: resource.etag,
          put: (data, etag) => {
            resource.put(data, etag);
            reread();
          },
        })
      }
    </div>
    ${mapped && chosen.data && h(FlankFigures, { figures: fit?.figures, level: chosen.data.spec.level ?? 0.95 })}
    ${mapped && chosen.data && h(FitCoefficients, { result: chosen.data.result, axes: iteration.axes, level: chosen.data.spec.level })}
  </div>`;
}

/** Part, flank and date of an iteration, for saved pictures. @param {Job} job @param {Iteration} iteration */
function aboutOf(job, { flank, tooth, measured_at, created_at }) {
  const { value } = fmt;
  return [
    job.name,
    job.part_number && `${common.part} ${job.part_number}`,
    job.serial_number && `${common.serial} ${job.serial_number}`,
    flank && `${t.flank} ${t[flank]}`,
    tooth && `${t.tooth} ${tooth}`,
    value.time(measured_at ?? created_at),
  ]
    .filter(Boolean)
    .join(" · ");
}

/** @param {import("../api/resource.js").Resource<any>} resource */
const settled = ({ data, error }) => data !== undefined || error !== undefined;

/**
 * @param {{ iteration: Iteration, etag: string | undefined, put: (iteration: Iteration, etag: string | undefined) => void }} props
 */
function Measured({ iteration, etag, put }) {
  const [editing, setEditing] = useState(false);
  const data = (/** @type {string | null | undefined} */ text) => text && html`<span translate="no">${text}</span>`;
  const items = [
    { name: t.flank, value: iteration.flank ? t[iteration.flank] : undefined },
    { name: t.tooth, value: data(iteration.tooth) },
    { name: t.unitOfDeviations, value: data(heightUnit(iteration.axes)) },
    { name: t.nodes, value: data(fmt.value.count(iteration.node_count)) },
    { name: t.measuredAt, value: iteration.measured_at && data(fmt.value.time(iteration.measured_at)) },
    { name: t.stored, value: data(fmt.value.time(iteration.created_at)) },
    { name: t.instrument, value: data(iteration.instrument) },
    { name: t.operator, value: data(iteration.operator) },
    { name: t.note, value: data(iteration.note) },
  ].flatMap(({ name, value }) => (value ? [{ name, value }] : []));
  return html`<section class="panel" aria-labelledby="measured">
    <h2 id="measured">${t.measurement}</h2>${h(Facts, { items, columns: true })}
    ${
      mayBeFlank(iteration.axes) &&
      may("decide") &&
      html`<div class="actions">
        <button type="button" class="button small" onClick=${() => setEditing(true)}>${t.editMeasurand}</button>
      </div>`
    }
    ${editing && h(EditMeasurand, { iteration, etag, put, onClose: () => setEditing(false) })}
  </section>`;
}

/**
 * @param {{ job: Job, iteration: Iteration, traced: readonly TracedIteration[], traceSettled: boolean, fitId: string | undefined,
 *   chosen: import("../api/client.js").Schema<"IterationFit"> | undefined, exclusion: import("../flank/exclude.js").Exclusion,
 *   onMapped: () => void }} props
 *   `onMapped`: called when the map has its final height
 */
function Layers({ job, iteration, traced, traceSettled, fitId, chosen, exclusion, onMapped }) {
  const others = traced.filter(({ number }) => number !== iteration.number).map(({ number }) => number);
  const corrected = traced.some(
    ({ number, records }) => number === iteration.number && records?.some(({ kind }) => kind === "correction"),
  );
  // IDs are in the order of time, whatever the order of the response
  const teeth = (traced.find(({ number }) => number === iteration.number)?.records ?? [])
    .flatMap(({ kind, id }) => (kind === "deviations" ? [id] : []))
    .sort();
  const layer = LAYERS.find((name) => name === query.value.get("layer")) ?? "measured";
  const wanted = Number(query.value.get("with"));
  const other = others.includes(wanted) ? wanted : (others.filter((one) => one < iteration.number).at(-1) ?? others[0]);
  const shown = useLayer({
    jobId: job.id,
    number: iteration.number,
    fitId,
    layer,
    other,
    corrected,
    measurand: iteration,
  });
  const { flank, axes } = iteration;
  const designed = job.requirements?.design && job.gear && flank && axes?.u && axes.v && micrometres(axes);
  const offered = LAYERS.filter(
    (name) =>
      (name !== "from_design" || designed || layer === "from_design") &&
      (name !== "difference" || others.length > 0) &&
      ((name !== "predicted" && name !== "answered") || corrected) &&
      (name !== "teeth" || teeth.length > 0 || layer === "teeth") &&
      (name !== "answered" || layer === "answered" || shown.answered || layer !== "predicted"),
  );
  const ofCorrection = layer === "predicted" || layer === "answered";
  const unit = ofCorrection || layer === "from_design" ? "µm" : (heightUnit(iteration.axes) ?? common.callersUnit);
  // residuals and differences are smaller than measured deviations and have their own scale
  const compared = layer !== "residual" && layer !== "difference" && layer !== "from_design";
  const alike = traced.filter(({ axes }) => (heightUnit(axes) ?? common.callersUnit) === unit);
  const scale = useJobLimit(
    job.id,
    alike.map(({ number }) => number),
  );
  const loading = shown.loading || !traceSettled || (compared && !scale.ready);
  const place = useRef(/** @type {HTMLElement | null} */ (null));
  const height = useRef(0);
  useLayoutEffect(() => {
    if (loading) return;
    height.current = place.current?.offsetHeight ?? 0;
    if (layer !== "teeth") onMapped();
  });
  const chooser = html`<div class="layer-choice">
    ${h(SelectField, {
      label: t.layer,
      required: true,
      value: layer,
      options: offered.map((name) => ({ value: name, label: t[name] })),
      onChange: (value) => setQuery({ layer: value === "measured" ? undefined : value }, { step: true }),
    })}
    ${
      layer === "difference" &&
      h(SelectField, {
        label: t.minus,
        required: true,
        value: String(other ?? ""),
        options: others.map((one) => ({ value: String(one), label: common.iteration(one) })),
        onChange: (value) => setQuery({ with: value }, { step: true }),
      })
    }
  </div>`;
  const failures = shown.errors.map(({ error, reload }, i) => h(Failure, { key: i, error, retry: reload }));
  const nodes = shown.nodes.data;
  /** @type {import("../../vendor/ui.js").ComponentChildren} */
  let content = null;
  if (layer === "teeth" && teeth.length > 0) {
    content = h(AllTeeth, {
      jobId: job.id,
      number: iteration.number,
      records: teeth,
      name: common.iteration(iteration.number),
      flipU: job.gear?.internal === true,
      file: `${job.name}-${iteration.number}-${layer}`,
      onShown: onMapped,
    });
  } else if (loading && (OF_TRACE.includes(layer) || (compared && !scale.ready))) {
    content = h(Skeleton, { lines: 14 });
  } else if (nodes?.type === "curve") {
    content = h(FlankCurve, {
      nodes,
      residuals: shown.residuals,
      layer,
      axes: iteration.axes,
      file: `${job.name}-${iteration.number}-${layer}`,
    });
  } else if (nodes?.type === "matrix") {
    content = h(Empty, { children: t.noMap });
  } else if (shown.surface) {
    content = h(FlankView, {
      surface: shown.surface,
      title: t[layer],
      name: `${common.iteration(iteration.number)}: ${layer === "difference" && other !== undefined ? t.lessIteration(other) : t[layer]}`,
      unit,
      axes: iteration.axes,
      range: chosen?.result.domain,
      ...(layer === "teeth" || !chosen ? {} : { marks: marksOf(chosen.result.warnings, exclusion.excluded) }),
      action: exclusion.allowed ? (/** @type {number} */ index) => h(NodeAction, { exclusion, index }) : undefined,
      flipU: job.gear?.internal === true,
      file: `${job.name}-${iteration.number}-${layer}`,
      atLeast: compared ? scale.limit : 0,
      about: aboutOf(job, iteration),
    });
  } else if (loading) content = h(Skeleton, { lines: 14 });
  else if (failures.length === 0) content = h(Empty, { children: t.noLayer });
  return html`<section class="panel map-panel" aria-labelledby="map" ref=${place} style=${loading ? { minHeight: `${height.current}px` } : undefined}>
    <header><h2 id="map">${t.map}</h2>${chooser}</header>
    ${failures}${content}
    ${layer === "difference" && !shown.exact && html`<p class="hint">${t.interpolated}</p>`}
    ${ofCorrection && shown.correction && !hasDatum(shown.correction) && html`<p class="hint">${correctionText.withoutMean}</p>`}
    ${layer === "answered" && shown.correction?.answer && html`<p class="hint">${t.answeredBy(shown.correction.answer.iteration)}</p>`}
  </section>`;
}
