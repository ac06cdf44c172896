// A page: its title in tab and heading, its actions, its content.

import { may } from "../api/key.js";
import { t } from "../i18n/common.js";
import { href, hrefIf } from "../router.js";
import { current, query } from "../navigation.js";
import { h, html, useEffect, useRef } from "../../vendor/ui.js";

/** @typedef {import("../../vendor/ui.js").ComponentChildren} Children */

/** Set once a page has been shown. */
let begun = false;

/**
 * @param {{
 *   title: string,
 *   heading?: Children,
 *   above?: Children,
 *   about?: Children,
 *   actions?: Children,
 *   children: Children,
 * }} props `title` names the tab, and the page where there is no `heading`; `above`: where the page belongs;
 *   `about`: a line below the heading
 */
export function Page({ title, heading, above, about, actions, children }) {
  const focus = useRef(/** @type {HTMLHeadingElement | null} */ (null));
  useEffect(() => {
    document.title = `${title} – flankfit`;
  }, [title]);
  // after a change of page, keyboard and screen reader begin here, too
  useEffect(() => {
    if (begun && document.activeElement === document.body) focus.current?.focus({ preventScroll: true });
    begun = true;
  }, []);
  return html`<div class="page">
    <div class="page-head">
      <div class="page-title">
        ${above && html`<p class="above">${above}</p>`}
        <h1 ref=${focus} tabindex="-1">${heading ?? title}</h1>
        ${about && html`<p class="about">${about}</p>`}
      </div>
      ${actions && html`<div class="actions">${actions}</div>`}
    </div>
    ${children}
  </div>`;
}

const MEASURE = "/jobs/{job_id}/measure";

/** The views of a job in their order; those without a page are not shown. */
const JOB_VIEWS = /** @type {const} */ ([
  ["/jobs/{job_id}", "overview"],
  [MEASURE, "measure"],
  ["/jobs/{job_id}/trace", "trace"],
  ["/jobs/{job_id}/report", "report"],
]);

/** The views of an iteration, as above. */
const ITERATION_VIEWS = /** @type {const} */ ([
  ["/jobs/{job_id}/iterations/{number}", "map"],
  ["/jobs/{job_id}/iterations/{number}/lambda", "lambda"],
  ["/jobs/{job_id}/iterations/{number}/statistics", "statistics"],
  ["/jobs/{job_id}/iterations/{number}/evaluation", "evaluation"],
  ["/jobs/{job_id}/iterations/{number}/correction", "correction"],
]);

/**
 * Navigation within a job, and within one of its iterations.
 * @param {{ jobId: string, number?: number | undefined, iterations?: readonly number[] }} props
 *   `number`: the iteration that is shown; `iterations`: those that there are
 */
export function JobNavigation({ jobId, number, iterations = [] }) {
  const here = current.value?.page.path;
  const map = "/jobs/{job_id}/iterations/{number}";
  /** @param {string} path @param {string} label @param {boolean} [marked] @param {number} [of] */
  const entry = (path, label, marked = here === path, of = number) => {
    if (path === MEASURE && !may("measure")) return null;
    // layer, scale, contours and crosshair are kept from map to map
    const seen = path === map && here === map ? Object.fromEntries(query.value) : {};
    const to = hrefIf(path, { job_id: jobId, ...(of === undefined ? {} : { number: of }) }, seen);
    const key = path + (of ?? "");
    return to && html`<li key=${key}><a href=${to} aria-current=${marked ? "page" : undefined}>${label}</a></li>`;
  };
  // the current view stays in sight
  const tabs = useRef(/** @type {HTMLElement | null} */ (null));
  useEffect(() => {
    for (const list of tabs.current?.children ?? []) {
      const shown = list.querySelector("[aria-current]")?.getBoundingClientRect();
      const { left, right } = list.getBoundingClientRect();
      if (shown) list.scrollLeft += Math.max(0, shown.right - right) + Math.min(0, shown.left - left);
    }
  }, [here, number, iterations.length]);
  const [overview, measure, ...rest] = JOB_VIEWS.map(([path, label]) => entry(path, t[label]));
  return html`<nav class="job-navigation" ref=${tabs} aria-label=${t.jobNavigation}>
    <ul>${overview}${measure}${iterations.map((one) => entry(map, t.iteration(one), one === number, one))}${rest}</ul>
    ${number !== undefined && html`<ul class="second">${ITERATION_VIEWS.map(([path, label]) => entry(path, t[label]))}</ul>`}
  </nav>`;
}

/** A path that names no page. */
export function NoSuchPage() {
  return h(Page, {
    title: t.noSuchPage,
    children: html`<p>${t.noSuchPageText}</p><p><a href=${href("/jobs")}>${t.backToJobs}</a></p>`,
  });
}
