// The pages and their paths. A page is one module whose default export is its component; it is
// loaded when somebody goes there. The server has the same paths (`PAGES` in src/http/dashboard.rs;
// a test compares the two lists).

import { may } from "./api/key.js";

/** @typedef {import("../vendor/ui.js").ComponentType<{ params: Record<string, string> }>} PageComponent */
/** @typedef {{ default: PageComponent, styles?: readonly string[] }} PageModule */

/** `page` is a module of `pages/`. @satisfies {readonly { path: string, page: string }[]} */
export const pages = /** @type {const} */ ([
  { path: "/jobs", page: "jobs" },
  { path: "/jobs/new", page: "new_job" },
  { path: "/jobs/{job_id}", page: "job" },
  { path: "/jobs/{job_id}/measure", page: "measure" },
  { path: "/jobs/{job_id}/iterations/{number}", page: "iteration" },
  { path: "/jobs/{job_id}/iterations/{number}/evaluation", page: "evaluation" },
  { path: "/jobs/{job_id}/iterations/{number}/correction", page: "correction" },
  { path: "/jobs/{job_id}/streams/{stream_id}", page: "stream" },
  { path: "/fit", page: "fit" },
  { path: "/settings", page: "settings" },
  { path: "/jobs/{job_id}/iterations/{number}/lambda", page: "lambda" },
  { path: "/jobs/{job_id}/trace", page: "trace" },
  { path: "/jobs/{job_id}/report", page: "report" },
  { path: "/jobs/{job_id}/iterations/{number}/statistics", page: "statistics" },
]);

/** @typedef {(typeof pages)[number]["path"]} PagePath */

/** Loads a page. @param {(typeof pages)[number]} page @returns {Promise<PageModule>} */
export function load({ page }) {
  return import(`./pages/${page}.js`);
}

/**
 * Returns the page of a path. Paths without parameters come first.
 * @param {string} pathname
 */
export function match(pathname) {
  const segments = pathname.split("/");
  const ordered = [...pages].sort((a, b) => a.path.split("{").length - b.path.split("{").length);
  for (const page of ordered) {
    const params = matchSegments(page.path.split("/"), segments);
    if (params) return { page, params };
  }
  return undefined;
}

/** @param {string[]} pattern @param {string[]} segments */
function matchSegments(pattern, segments) {
  if (pattern.length !== segments.length) return undefined;
  /** @type {Record<string, string>} */
  const params = {};
  for (const [i, part] of pattern.entries()) {
    const segment = segments[i] ?? "";
    const name = /^\{(\w+)\}$/.exec(part)?.[1];
    if (name === undefined) {
      if (part !== segment) return undefined;
    } else {
      const value = decoded(segment);
      if (!value) return undefined;
      params[name] = value;
    }
  }
  return params;
}

/** @param {string} segment */
function decoded(segment) {
  try {
    return decodeURIComponent(segment);
  } catch {
    return undefined;
  }
}

/**
 * Returns the address of a page. Links come from here, never from data.
 * @param {PagePath} path @param {Record<string, string | number>} [params]
 * @param {Record<string, string | number | undefined>} [query]
 */
export function href(path, params = {}, query = {}) {
  return filled(path, params, query);
}

/**
 * Returns the address of a page that may be missing; undefined then, so that there is no link.
 * @param {string} path @param {Record<string, string | number>} [params]
 * @param {Record<string, string | number | undefined>} [query]
 */
export function hrefIf(path, params = {}, query = {}) {
  return pages.some((page) => page.path === path) ? filled(path, params, query) : undefined;
}

/** Returns the address of the page that measures a job, if the caller may. @param {string} jobId */
export function toMeasure(jobId) {
  return may("measure") ? href("/jobs/{job_id}/measure", { job_id: jobId }) : undefined;
}

/** @param {string} path @param {Record<string, string | number>} params @param {Record<string, string | number | undefined>} query */
function filled(path, params, query) {
  const whole = path.replaceAll(/\{(\w+)\}/g, (_, name) => {
    const value = params[name];
    if (value === undefined || value === "") throw new Error(`${path} needs ${name}`);
    return encodeURIComponent(value);
  });
  const search = new URLSearchParams();
  for (const [name, value] of Object.entries(query)) {
    if (value !== undefined && value !== "") search.set(name, String(value));
  }
  return search.size > 0 ? `${whole}?${search}` : whole;
}
