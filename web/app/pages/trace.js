// The story of a job: a column for each iteration, time downwards.

import { Checkbox } from "../components/form.js";
import { JobPage } from "../components/job_page.js";
import { Empty, loaded, measureAction } from "../components/states.js";
import { t as common } from "../i18n/common.js";
import de from "../i18n/de/trace.js";
import en from "../i18n/en/trace.js";
import { texts } from "../i18n/i18n.js";
import { heightUnit } from "../lib/units.js";
import { query, setQuery } from "../navigation.js";
import { hrefIf } from "../router.js";
import { Compare } from "../trace/compare.js";
import { entriesOf, KINDS } from "../trace/entries.js";
import { EntryText } from "../trace/entry.js";
import { h, html, useLayoutEffect, useRef, useState } from "../../vendor/ui.js";

/** @typedef {import("../api/job.js").TracedIteration} TracedIteration */
/** @typedef {import("../trace/entries.js").Entry} Entry */

export const styles = ["trace"];
const t = texts({ en, de });

/** @param {{ params: Record<string, string> }} props */
export default function TracePage({ params }) {
  const jobId = params["job_id"] ?? "";
  return h(JobPage, {
    jobId,
    view: common.trace,
    children: (_, { trace }) =>
      loaded({
        resource: trace,
        lines: 14,
        children: ({ iterations }) =>
          iterations.length === 0
            ? h(Empty, { children: t.none, action: measureAction(jobId) })
            : html`<div class="trace-page">${h(Story, { jobId, iterations })}${h(Compare, { iterations })}</div>`,
      }),
  });
}

/** @param {{ jobId: string, iterations: readonly TracedIteration[] }} props */
function Story({ jobId, iterations }) {
  const hidden = new Set((query.value.get("hide") ?? "").split(","));
  const entries = entriesOf(iterations).filter(({ kind }) => !hidden.has(kind));
  const column = new Map(iterations.map(({ number }, i) => [number, i + 1]));
  const units = new Map(iterations.map(({ number, axes }) => [number, heightUnit(axes)]));
  const toggle = (/** @type {string} */ kind, /** @type {boolean} */ shown) => {
    if (shown) hidden.delete(kind);
    else hidden.add(kind);
    setQuery({ hide: KINDS.filter((one) => hidden.has(one)).join(",") });
  };
  const box = useRef(/** @type {HTMLDivElement | null} */ (null));
  const earlier = iterations.some((one) => one.earlier);
  return html`<section class="trace-story">
    <div><h2>${t.title}</h2><p class="quiet">${t.aboutTrace}</p></div>
    <fieldset class="trace-filter"><legend class="visually-hidden">${t.filter}</legend>
      ${KINDS.map((kind) => h(Checkbox, { key: kind, label: t[`show_${kind}`], checked: !hidden.has(kind), onChange: (shown) => toggle(kind, shown) }))}
    </fieldset>
    ${earlier && html`<p class="note">${t.earlier}</p>`}
    <div class="trace-scroll" tabindex="0" role="region" aria-label=${t.title}>
      <div class="trace-grid" ref=${box}>
        ${h(Links, { box, entries })}
        ${iterations.map((one, i) => html`<header key=${one.id} style=${{ gridColumn: i + 1, gridRow: 1 }}>${h(Head, { jobId, iteration: one })}</header>`)}
        <ol class="trace-entries">
          ${entries.map(
            (entry, i) => html`<li key=${entry.id} data-entry=${entry.id} class=${`trace-entry ${entry.kind}`}
              style=${{ gridColumn: column.get(entry.iteration), gridRow: i + 2 }}>
              ${h(EntryText, { entry, jobId, unit: units.get(entry.iteration) })}
            </li>`,
          )}
        </ol>
      </div>
    </div>
  </section>`;
}

/** @param {{ jobId: string, iteration: TracedIteration }} props */
function Head({ jobId, iteration: { number, flank, tooth, instrument, operator } }) {
  const to = hrefIf("/jobs/{job_id}/iterations/{number}", { job_id: jobId, number });
  const name = common.iteration(number);
  const said = (/** @type {string} */ label, /** @type {string | null | undefined} */ text) =>
    text && html`<span>${label} <b translate="no">${text}</b></span>`;
  return html`<h3>${to ? html`<a href=${to}>${name}</a>` : name}</h3>
    <p class="quiet trace-who">
      ${flank && html`<span>${t[flank]}</span>`}${said(t.tooth, tooth)}${said(t.instrument, instrument)}${said(t.operator, operator)}
    </p>`;
}

/** Lines from corrections to the iterations that measured them. @param {{ box: { current: HTMLDivElement | null }, entries: readonly Entry[] }} props */
function Links({ box, entries }) {
  const [paths, setPaths] = useState("");
  useLayoutEffect(() => {
    const element = box.current;
    if (!element) return undefined;
    const draw = () => {
      const origin = element.getBoundingClientRect();
      const place = (/** @type {string} */ id) =>
        element.querySelector(`[data-entry="${CSS.escape(id)}"]`)?.getBoundingClientRect();
      const lines = entries.flatMap((entry) => {
        if (entry.kind !== "measured" || !entry.correction) return [];
        const [from, to] = [place(entry.correction), place(entry.id)];
        if (!from || !to || to.left < from.right) return [];
        const [x1, y1] = [from.right - origin.left, from.top + from.height / 2 - origin.top];
        const [x2, y2] = [to.left - origin.left, to.top + Math.min(24, to.height / 2) - origin.top];
        const middle = x2 - (x2 - x1) / 2;
        return [`M${x1} ${y1}H${middle}V${y2}H${x2 - 2}m-6 -4l6 4l-6 4`];
      });
      setPaths(lines.join(""));
    };
    draw();
    const observer = new ResizeObserver(draw);
    observer.observe(element);
    return () => observer.disconnect();
  }, [entries.map(({ id }) => id).join(" ")]);
  return html`<svg class="trace-links" aria-hidden="true"><path d=${paths} /></svg>`;
}
