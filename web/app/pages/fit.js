// Fits nodes of a file or of pasted text, and stores nothing until they are saved.

import { answer, api } from "../api/client.js";
import { may } from "../api/key.js";
import { useResource } from "../api/resource.js";
import { CancelledError, useWatched } from "../api/watched.js";
import { Allowed } from "../components/allowed.js";
import { Facts } from "../components/figure.js";
import { FigureTiles } from "../components/figure_tiles.js";
import { FlankFigures } from "../components/flank_figures.js";
import { SelectField } from "../components/form.js";
import { emptyGear, GearFields, useRested } from "../components/gear_fields.js";
import { AxesField, FlankField, measurandInWords, UnitField } from "../components/measurand_fields.js";
import { NodesInput } from "../components/nodes_input.js";
import { Page } from "../components/page.js";
import { bodyOf, SaveIteration } from "../components/save_iteration.js";
import { Empty, Failure, loaded } from "../components/states.js";
import { Underway } from "../components/underway.js";
import { criterionLabel } from "../components/criterion.js";
import { FlankCurve } from "../flank/curve.js";
import { CoefficientTable, FitFacts, Warnings } from "../flank/figures.js";
import { atNodes, surfaceOf } from "../flank/layers.js";
import { FlankView } from "../flank/view.js";
import de from "../i18n/de/fit.js";
import en from "../i18n/en/fit.js";
import { t as common } from "../i18n/common.js";
import { fmt, texts } from "../i18n/i18n.js";
import { digestOf } from "../lib/digest.js";
import { useDraft } from "../lib/draft.js";
import { flankSurfaceRequest, hasMore, isOverFlank, isSecondOrder } from "../lib/flank_surface.js";
import { gearOf } from "../lib/gear_form.js";
import { readNodes, specOf } from "../lib/nodes_file.js";
import { heightUnit } from "../lib/units.js";
import { likelyAlong, likelyFlank, likelyUnit } from "../measure/likely.js";
import { axesOf } from "../measure/request.js";
import { query, setQuery } from "../navigation.js";
import { Fragment, h, html, useMemo, useState } from "../../vendor/ui.js";

/** @typedef {import("../api/client.js").Schema<"FitResult">} FitResult */
/** @typedef {import("../api/client.js").Schema<"Axes">} Axes */
/** @typedef {import("../api/client.js").Schema<"Gear">} Gear */
/** @typedef {ReturnType<typeof surfaceOf>} Surface */
/** @typedef {import("../lib/nodes_file.js").NodesFile} NodesFile */
/** @typedef {import("../lib/nodes_file.js").Fields} Fields */
/** @typedef {{ file: NodesFile, name: string, turn: number }} Given */

const t = texts({ en, de });
export const styles = ["iteration", "fit"];

const CRITERIA = /** @type {const} */ (["min_mse", "gcv", "l_curve", "discrepancy", "min_condition"]);
const LAYERS = /** @type {const} */ (["measured", "fitted", "residual"]);
/** @type {import("../components/save_iteration.js").Target} */
const NO_TARGET = { find: "", jobId: "" };
let turns = 0;

export default function FitPage() {
  const [given, setGiven] = useState(givenBefore);
  const degree = query.value.get("degree") ?? undefined;
  const by = query.value.get("by") ?? undefined;
  const [gearForm, setGearForm] = useDraft("gear of /fit", emptyGear);
  const { gear } = gearOf(gearForm);
  const measured = useMemo(() => given && surfaceOf(given.file.nodes), [given]);
  const measurand = given && measurandOf(given, measured, gear);
  const key = JSON.stringify([measurand?.axes, measurand?.flank, measurand?.unit]);
  const spec = useMemo(
    () => given && measurand && withMeasurand(specOf(given.file, { degree, by }), given.file, measurand),
    [given, degree, by, key],
  );
  // kept here: every other fit remounts its result and the form that saves it
  const [target, setTarget] = useState(NO_TARGET);
  const watched = useWatched();
  const fit = useResource(given && spec ? `fit of ${given.turn} ${degree ?? ""} ${by ?? ""} ${key}` : null, (signal) =>
    watched.run(
      (how) => api.POST("/v1/fits", { ...how, ...(given && spec ? bodyOf(given.file, spec) : neverSent()) }),
      signal,
    ),
  );
  const stopped = fit.error instanceof CancelledError && common.stopped;
  const take = (/** @type {NodesFile} */ file, /** @type {string} */ name) => {
    turns += 1;
    setQuery({ at: undefined, zoom: undefined, limit: undefined, layer: undefined });
    setQuery({ flank: undefined, axes: undefined, unit: undefined });
    setGiven({ file, name, turn: turns });
    setTarget(NO_TARGET);
    keep(file.text, name);
  };
  // the result shown belongs to the previous file
  const refuse = () => {
    setGiven(undefined);
    keep("", "");
  };
  return h(Page, {
    title: common.fit,
    about: t.about,
    children: !may("compute")
      ? h(Allowed, { scope: "compute", children: () => null })
      : html`<div class="fit-input">
        ${h(NodesInput, { onNodes: take, onRefused: refuse })}
        ${h(Choices, { file: given?.file, degree, by })}
      </div>
      ${given && measurand && spec && h(Measurand, { file: given.file, surface: measured, measurand, spec, gear, gearForm, setGearForm })}
      ${h(Underway, { watched, label: t.fitting })}
      ${
        stopped
          ? h(Empty, {
              children: stopped,
              action: { label: common.tryAgain, onClick: fit.reload },
            })
          : given && spec
            ? loaded({
                resource: fit,
                lines: 12,
                children: (result) => h(Fitted, { key: given.turn, given, spec, gear, result, target, setTarget }),
              })
            : h(Empty, { children: t.none })
      }`,
  });
}

const PLACE = "flankfit.draft nodes of /fit";
/** The maximum size: longer texts would leave no space for other drafts. */
const MOST_KEPT = 2_000_000;

/** @param {string} text @param {string} name */
function keep(text, name) {
  try {
    if (text.length > MOST_KEPT) sessionStorage.removeItem(PLACE);
    else sessionStorage.setItem(PLACE, JSON.stringify({ text, name }));
  } catch {
    // a full store loses only persistence over reloads
  }
}

/** Returns the nodes fitted before a reload. @returns {Given | undefined} */
function givenBefore() {
  try {
    const { text, name } = JSON.parse(sessionStorage.getItem(PLACE) ?? "{}");
    const { file } = typeof text === "string" ? readNodes(text) : { file: undefined };
    if (!file) return undefined;
    turns += 1;
    return { file, name: String(name), turn: turns };
  } catch {
    return undefined;
  }
}

/** @returns {never} */
function neverSent() {
  throw new Error("no nodes");
}

/** @param {{ file: NodesFile | undefined, degree: string | undefined, by: string | undefined }} props */
function Choices({ file, degree = "", by = "" }) {
  const ofFile = file !== undefined && "model" in file.spec;
  const choose = (/** @type {"degree" | "by"} */ name) => (/** @type {string} */ value) =>
    setQuery({ [name]: value }, { step: true });
  return html`<section class="panel" aria-labelledby="model">
    <h2 id="model">${t.model}</h2>
    ${h(SelectField, {
      label: t.polynomial,
      required: true,
      hint: t.polynomialHint,
      value: degree,
      onChange: choose("degree"),
      options: [
        { value: "", label: ofFile ? t.asFile : t.secondOrder },
        ...[1, 2, 3, 4].map((n) => ({ value: String(n), label: t.degree(n) })),
      ],
    })}
    ${h(SelectField, {
      label: t.lambda,
      required: true,
      value: by,
      onChange: choose("by"),
      options: [
        { value: "", label: file !== undefined && "regularization" in file.spec ? t.asFile : t.byDefault },
        ...CRITERIA.map((name) => ({
          value: name,
          label: html`${criterionLabel(name)} <span translate="no">(${name})</span>`,
        })),
        { value: "none", label: t.notRegularised },
      ],
    })}
  </section>`;
}

/** The measured quantity: as the file says, as was chosen, or what is most likely. @typedef {{ flank: string, axes: string, unit: string, named: boolean }} Measurand */

/** @param {Given} given @param {Surface} surface @param {Gear | undefined} gear @returns {Measurand} */
function measurandOf({ file, name }, surface, gear) {
  const { flank, axes } = /** @type {{ flank?: string, axes?: Axes }} */ (file.spec);
  const chosen = (/** @type {string} */ what) => query.value.get(what) ?? "";
  return {
    flank: chosen("flank") || (flank ?? likelyFlank(name)),
    axes: chosen("axes") || (likelyAlong(surface, gear) ?? "none"),
    unit: chosen("unit") || likelyUnit(surface),
    named: axes?.z !== undefined || axes?.y !== undefined,
  };
}

/** @param {Fields} spec @param {NodesFile} file @param {Measurand} measurand @returns {Fields} */
function withMeasurand(spec, { nodes }, { flank, axes, unit, named }) {
  return {
    ...spec,
    ...(flank ? { flank } : {}),
    ...(named || axes === "none" || nodes.type === "matrix"
      ? {}
      : { axes: axesOf({ axes, unit }, nodes.type === "curve") }),
  };
}

/**
 * @param {{ file: NodesFile, surface: Surface, measurand: Measurand, spec: Fields, gear: Gear | undefined,
 *   gearForm: import("../lib/gear_form.js").GearForm, setGearForm: (form: import("../lib/gear_form.js").GearForm) => void }} props
 */
function Measurand({ file, surface, measurand, spec, gear, gearForm, setGearForm }) {
  const { named, axes } = measurand;
  const choice = (/** @type {"flank" | "axes" | "unit"} */ what) => ({
    value: measurand[what],
    onChange: (/** @type {string} */ value) => setQuery({ [what]: value }, { step: true }),
  });
  if (file.nodes.type === "matrix") return null;
  const words = named ? undefined : measurandInWords(surface, measurand);
  const of = /** @type {Axes | undefined} */ (spec["axes"]);
  const without = measurand.flank && gear && isOverFlank(file.nodes, of) && hasMore(file.nodes, of, spec);
  return html`<section class="panel fit-measurand" aria-labelledby="measurand">
    <h2 id="measurand">${t.measurand}</h2>
    <div class="fields thirds">
      ${h(FlankField, { ...choice("flank"), none: measurand.flank ? undefined : t.notSaid })}
      ${!named && h(AxesField, choice("axes"))} ${!named && axes !== "none" && h(UnitField, choice("unit"))}
    </div>
    ${words && html`<p class="notice">${words}</p>`}
    ${
      surface &&
      html`<h3>${t.gear}</h3><p class="quiet">${without ? t.noFigures : t.figuresNeed}</p>
      ${h(GearFields, { form: gearForm, onChange: setGearForm, error: undefined, at: "/gear", submitted: false })}`
    }
  </section>`;
}

/**
 * Returns slopes, crownings and twist; undefined while their flank, axes or gear are unknown.
 * @param {NodesFile} file @param {Fields} spec @param {Gear | undefined} gear
 */
function useFigures(file, spec, gear) {
  const { flank, axes } = /** @type {{ flank?: "left" | "right", axes?: Axes }} */ (spec);
  const rested = useRested(JSON.stringify(gear));
  const request = useMemo(
    () =>
      flank && rested ? flankSurfaceRequest(file.nodes, { axes, flank, gear: JSON.parse(rested), spec }) : undefined,
    [file, spec, rested],
  );
  const key = useMemo(() => request && digestOf(JSON.stringify(request)), [request]);
  return useResource(request ? `figures ${key}` : null, (signal) =>
    answer(api.POST("/v1/gears/flank-surface", { signal, body: request ?? neverSent() })),
  );
}

/**
 * @param {{ given: Given, spec: Fields, gear: Gear | undefined, result: FitResult, target: import("../components/save_iteration.js").Target,
 *   setTarget: (target: import("../components/save_iteration.js").Target) => void }} props
 */
function Fitted({ given: { file, name }, spec, gear, result, target, setTarget }) {
  const axes = /** @type {Axes | undefined} */ (spec["axes"]);
  const level = typeof spec["level"] === "number" ? spec["level"] : 0.95;
  const figures = useFigures(file, spec, gear);
  return html`<div class="flank-page">
    <div class="flank-main">
      ${figures.error !== undefined && h(Failure, { error: figures.error, retry: figures.reload })}
      ${h(FigureTiles, { figures: figures.data })}
      ${figures.data && !isSecondOrder(spec["model"]) && html`<p class="hint">${t.otherModel}</p>`}
      ${h(Layers, { file, name, axes, result })}
      <section class="panel" aria-labelledby="coefficients">
        <h2 id="coefficients">${t.coefficients}</h2>
        ${h(CoefficientTable, { result, axes, level, hideCaption: true })}
      </section>
    </div>
    <div class="flank-aside">
      ${h(Counts, { file, name, result })}
      <section class="panel" aria-labelledby="figures">
        <h2 id="figures">${t.figures}</h2>${h(FitFacts, { result, axes })}
      </section>
      ${h(Warnings, { result })}
      ${may("measure") && h(SaveIteration, { file, spec: { ...spec, include: file.spec["include"] }, target, setTarget })}
    </div>
    ${figures.data && h(FlankFigures, { figures: figures.data, level })}
  </div>`;
}

/** @param {{ file: NodesFile, name: string, result: FitResult }} props */
function Counts({ file, name, result: { residuals, coefficients } }) {
  const count = (/** @type {number} */ value) => html`<span translate="no">${fmt.value.count(value)}</span>`;
  const items = [
    { name: t.source, value: name ? html`<span translate="no">${name}</span>` : t.pastedText },
    { name: t.kind, value: t[file.nodes.type] },
    { name: t.nodes, value: count(file.count) },
    { name: t.missing, value: count(file.missing) },
    { name: t.counted, value: count(residuals.count) },
    { name: t.coefficients, value: count(coefficients.length) },
    { name: t.freedom, value: count(residuals.degrees_of_freedom) },
  ];
  return html`<section class="panel" aria-labelledby="counts">
    <h2 id="counts">${t.counts}</h2>${h(Facts, { items, columns: true })}
  </section>`;
}

/** @param {{ file: NodesFile, name: string, axes: Axes | undefined, result: FitResult }} props */
function Layers({ file, name, axes, result: { residuals, domain } }) {
  const layer = LAYERS.find((one) => one === query.value.get("layer")) ?? "measured";
  const measured = useMemo(() => surfaceOf(file.nodes), [file]);
  const surface = useMemo(() => {
    const values = layer === "residual" ? residuals.values : residuals.fitted;
    if (!measured || layer === "measured") return measured;
    return values && atNodes(measured, values, residuals.node_indices);
  }, [measured, residuals, layer]);
  const saved = `${name.replace(/\.\w+$/, "") || "nodes"}-${layer}`;
  /** @type {import("../../vendor/ui.js").ComponentChildren} */
  let content = h(Empty, { children: t.noMap });
  if (file.nodes.type === "curve") {
    content = h(FlankCurve, { nodes: file.nodes, residuals, layer, axes, file: saved });
  } else if (surface) {
    const unit = heightUnit(axes) ?? common.callersUnit;
    content = h(FlankView, { surface, title: t[layer], name: t[layer], unit, axes, range: domain, file: saved });
  }
  return html`<section class="panel map-panel" aria-labelledby="map">
    <header>
      <h2 id="map">${file.nodes.type === "curve" ? t.curve : t.map}</h2>
      <div class="layer-choice">
        ${h(SelectField, {
          label: t.layer,
          required: true,
          value: layer,
          options: LAYERS.map((one) => ({ value: one, label: t[one] })),
          onChange: (value) => setQuery({ layer: value === "measured" ? undefined : value }, { step: true }),
        })}
      </div>
    </header>
    ${h(Fragment, null, content)}
  </section>`;
}
