// One file of the queue: its contents, its map, the response of the server.

import { ApiError, OfflineError } from "../api/problem.js";
import { useAsTable } from "../components/as_table.js";
import { Badge, Facts } from "../components/figure.js";
import { Progress } from "../components/progress.js";
import { Failure } from "../components/states.js";
import { mapAxes } from "../flank/axes.js";
import { HeatMap, nodeText } from "../flank/heat_map.js";
import { MapTable } from "../flank/map_table.js";
import { Legend } from "../flank/legend.js";
import { boxOf, extremesOf } from "../flank/surface.js";
import { scaleFor } from "../flank/scale.js";
import { t as flank } from "../i18n/flank.js";
import { t as common } from "../i18n/common.js";
import de from "../i18n/de/measure.js";
import en from "../i18n/en/measure.js";
import { fmt, texts } from "../i18n/i18n.js";
import { heightUnit } from "../lib/units.js";
import { hrefIf } from "../router.js";
import { h, html } from "../../vendor/ui.js";
import { Columns } from "./columns.js";
import { OfGears } from "./of_gears.js";
import { nodeOfPointer } from "./request.js";
import { ChangedError } from "./send.js";

const t = texts({ en, de });

/** @typedef {import("./read.js").Content} Content */
/**
 * @typedef {object} Entry
 * @property {number} id
 * @property {File} file
 * @property {Content | undefined} content
 * @property {import("../api/client.js").Schema<"GearsOfFile"> | undefined} gears
 * @property {"waiting" | "sending" | "done" | "failed"} state
 * @property {unknown} error
 * @property {import("../components/progress.js").Done} progress
 * @property {number | undefined} number of the iteration that it became
 * @property {import("../api/attempt.js").Attempt} attempt
 */

const KINDS = /** @type {const} */ ({ waiting: "plain", sending: "plain", done: "good", failed: "bad" });

/**
 * @param {{ entry: Entry, most: number, jobId: string, fields: readonly string[], onRemove: () => void, onCancel: () => void,
 *   onMapping: (mapping: import("../lib/nodes_table.js").Mapping) => void }} props
 *   `most`: bytes that the server takes; `fields`: pointers of errors shown at fields
 */
export function QueueEntry({ entry, most, jobId, fields, onRemove, onCancel, onMapping }) {
  const { file, content, state, error, number, gears, progress } = entry;
  const to = number === undefined ? undefined : hrefIf("/jobs/{job_id}/iterations/{number}", { job_id: jobId, number });
  const counts = content && [
    { name: t.kind, value: t[/** @type {"grid"} */ (content.form || "unknown")] ?? t.unknown },
    ...(content.nodes > 0 ? [{ name: t.nodes, value: data(fmt.value.count(content.nodes)) }] : []),
    ...(content.surface?.kind === "grid"
      ? [{ name: t.size, value: data(`${content.surface.u.length} × ${content.surface.v.length}`) }]
      : []),
    ...(content.nodes > 0 ? [{ name: t.missing, value: data(fmt.value.count(content.missing)) }] : []),
    { name: t.bytes, value: data(`${fmt.value.count(Math.ceil(file.size / 1000))} kB`) },
  ];
  return html`<li class="panel queue-entry">
    <header>
      <h3 translate="no">${file.name}</h3>
      <div class="actions">
        <span aria-live="polite">${h(Badge, { kind: KINDS[state], children: error instanceof OfflineError ? t.unanswered : error instanceof ChangedError ? t.changed : t[state] })}</span>
        ${to && html`<a class="button small" href=${to}>${common.iteration(number ?? 0)}</a>`}
        ${state === "sending" && html`<button type="button" class="button small" onClick=${onCancel}>${common.cancel}</button>`}
        ${(state === "waiting" || state === "failed") && html`<button type="button" class="button small" onClick=${onRemove}>${t.remove}</button>`}
      </div>
    </header>
    ${state === "sending" && h(Progress, { label: t.sending, progress })}
    ${counts ? h(Facts, { items: counts }) : error === undefined && html`<p class="quiet">${t.reading}</p>`}
    ${content?.failure && html`<p class="field-error">${t[/** @type {"failure_json"} */ (`failure_${content.failure}`)]} <span lang="en" translate="no">${content.detail}</span></p>`}
    ${file.size > most && html`<p class="field-error">${t.tooLarge(`${fmt.value.count(Math.ceil(most / 1000))} kB`)}</p>`}
    ${content?.kind === "values" && html`<p class="notice warn">${t.valuesOnly}</p>`}
    ${content?.proposal && state !== "done" && h(Columns, { proposal: content.proposal, name: file.name, onMapping, disabled: state === "sending" })}
    ${gears && h(OfGears, { file: gears, name: file.name })}
    ${content && content.doubts.length > 0 && h(Doubts, { content })}
    ${error instanceof ChangedError ? html`<p class="field-error" role="alert">${t.changedOnDisk}</p>` : error !== undefined && h(Failure, { error, except: fields })}
    ${error instanceof ApiError && h(NodeFaults, { error })}
    ${content?.surface && h(Preview, { content, error, name: file.name })}
  </li>`;
}

/** @param {string} text */
const data = (text) => html`<span translate="no">${text}</span>`;

/** Cells that are not numbers, before anything is sent. @param {{ content: Content }} props */
function Doubts({ content }) {
  const place = (/** @type {string} */ at) => {
    const node = nodeOfPointer(at);
    if (node) return flank.cell(node.row + 1, node.column + 1);
    return at;
  };
  return html`<div class="field-error"><p>${t.doubts(content.doubts.length)}</p>
    <ul>${content.doubts.slice(0, 10).map(({ place: at, found }) => html`<li key=${at}>${place(at)}: <code translate="no">${found || "–"}</code></li>`)}</ul></div>`;
}

/** Errors of the server at single nodes, by row and column. @param {{ error: ApiError }} props */
function NodeFaults({ error }) {
  const errors = (error.problem.errors ?? []).flatMap(({ pointer, detail }) => {
    const node = nodeOfPointer(pointer);
    return node ? [{ pointer, detail, node }] : [];
  });
  if (errors.length === 0) return null;
  return html`<ul class="field-error" data-errors="nodes">
    ${errors.map(({ pointer, detail, node }) => html`<li key=${pointer}>${flank.cell(node.row + 1, node.column + 1)}: <span lang="en" translate="no">${detail}</span></li>`)}
  </ul>`;
}

/** @param {{ content: Content, error: unknown, name: string }} props */
function Preview({ content, error, name }) {
  const { surface } = content;
  const extremes = surface && extremesOf(surface);
  const { asTable, button } = useAsTable(t.previewOf(name));
  if (!surface || !extremes) return null;
  // scattered nodes that span no area have no map
  if (surface.kind === "scattered" && surface.triangles.length === 0) return null;
  const given = /** @type {import("../api/client.js").Schema<"Axes"> | undefined} */ (
    content.proposal?.axes ?? content.request?.["axes"]
  );
  const [axes, unit, whole] = [mapAxes(given), heightUnit(given), boxOf(surface)];
  const { limit, clipped } = scaleFor(surface);
  const says = (/** @type {import("../flank/surface.js").FlankNode} */ node) =>
    nodeText(node, { axes, unit, whole, limit });
  const refused =
    error instanceof ApiError ? (error.problem.errors ?? []).map(({ pointer }) => nodeOfPointer(pointer)) : [];
  const bad = [...refused, ...content.doubts.map(({ place }) => nodeOfPointer(place))].find(
    (node) => node !== undefined,
  );
  const at = bad && surface.kind === "grid" ? { u: surface.u[bad.row] ?? 0, v: surface.v[bad.column] ?? 0 } : undefined;
  const summary = flank.extremes(says(extremes.least), says(extremes.greatest));
  return html`<div class="measure-preview">
    <div class="actions end">${button}</div>
    ${asTable ? h(MapTable, { surface, title: flank.deviation, name: t.previewOf(name), unit, axes, csvName: name }) : h(HeatMap, { name: t.previewOf(name), summary, surface, limit, unit, axes, height: 240, lines: surface.z.length < 2000, at })}
    ${h(Legend, { limit, unit, clipped, missing: content.missing, small: true })}
    <p class="hint" translate="no">${summary}</p>
  </div>`;
}
