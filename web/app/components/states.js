// States of a page while data is loading, missing or refused.

import { keyWanted } from "../api/key.js";
import { ApiError, OfflineError } from "../api/problem.js";
import german from "../i18n/de/problems.js";
import { t } from "../i18n/common.js";
import { fmt } from "../i18n/i18n.js";
import { toMeasure } from "../router.js";
import { shownLanguage } from "../settings.js";
import { Fragment, h, html, useId } from "../../vendor/ui.js";

/** @typedef {import("../../vendor/ui.js").ComponentChildren} Children */
/** @typedef {{ label: string, to?: string, onClick?: () => void }} Action a link or a button */

/**
 * Placeholder lines for text; visible after 150 ms.
 * @param {{ lines?: number }} props
 */
export function Skeleton({ lines = 4 }) {
  return html`<div class="skeleton" aria-hidden="true">
    ${Array.from({ length: lines }, (_, i) => html`<span key=${i} class="skeleton-line"></span>`)}
  </div>`;
}

/**
 * An empty state: a sentence that says what will appear, and the action that leads there.
 * @param {{ children: Children, action?: Action | undefined, more?: Children }} props `more`: links of less weight
 */
export function Empty({ children, action, more }) {
  const main =
    action &&
    (action.to
      ? html`<a class="button primary" href=${action.to}>${action.label}</a>`
      : html`<button type="button" class="button primary" onClick=${action.onClick}>${action.label}</button>`);
  return html`<div class="empty">
    <p>${children}</p>
    ${(main || more) && html`<div class="actions">${main}${more}</div>`}
  </div>`;
}

/** Links to the page that measures a job, if the caller may. @param {string} jobId @returns {Action | undefined} */
export function measureAction(jobId) {
  const to = toMeasure(jobId);
  return to ? { label: t.measure, to } : undefined;
}

/**
 * A refusal or a lost connection, in full.
 * @param {{ error: unknown, retry?: (() => void) | undefined, retries?: boolean, back?: Children, except?: readonly string[] }} props
 *   `retries`: whether a request to a busy server is repeated; `except`: pointers of errors shown at their fields
 */
export function Failure({ error, retry, retries = false, back, except = [] }) {
  const id = useId();
  const { title, detail } = words(error);
  const refused = error instanceof ApiError ? error : undefined;
  const errors = refused?.errorsElsewhere(except) ?? [];
  // each error is shown once
  const [only] = errors.length === 1 ? errors : [];
  const twice = only && typeof detail === "string" && detail.replace(/\.$/, "") === `${only.pointer}: ${only.detail}`;
  const waits = refused?.status === 503 && refused.retryAfter !== undefined;
  return html`<section class="failure" role="alert" aria-labelledby=${id}>
    <h2 id=${id}>${title}</h2>
    ${detail && !twice && html`<p lang="en">${detail}</p>`}
    ${
      errors.length > 0 &&
      html`<ul class="errors">
        ${errors.map(
          ({ pointer, detail }) => html`<li key=${pointer}>
            <code translate="no">${pointer || "/"}</code> <span lang="en">${detail}</span>
          </li>`,
        )}
      </ul>`
    }
    ${waits && html`<p>${(retries ? t.asksAgain : t.askLater)(fmt.value.count(refused?.retryAfter ?? 0))}</p>`}
    ${refused?.requestId && html`<p class="quiet">${t.requestId} <code translate="no">${refused.requestId}</code></p>`}
    <div class="actions">
      ${retry && html`<button type="button" class="button" onClick=${retry}>${t.tryAgain}</button>`}
      ${refused?.status === 401 && html`<button type="button" class="button" onClick=${askForKey}>${t.enterKey}</button>`}
      ${back}
    </div>
  </section>`;
}

function askForKey() {
  keyWanted.value = "unauthorized";
}

/** @param {unknown} error */
function words(error) {
  if (error instanceof OfflineError) return { title: t.noAnswer, detail: "" };
  if (!(error instanceof ApiError))
    return { title: t.pageFailed, detail: error instanceof Error ? error.message : String(error) };
  const known = /** @type {Record<string, string>} */ ({
    unauthorized: t.keyNeeded,
    invalid_key: t.keyRefused,
    forbidden: t.notAllowed,
    not_found: t.notFound,
    precondition_failed: t.changedMeanwhile,
    invalid_request: t.invalidRequest,
    overloaded: t.overloaded,
    draining: t.overloaded,
    store_unavailable: t.storeUnavailable,
    too_many_requests: t.tooMany,
  });
  const own = shownLanguage.value === "de" ? german[error.code] : undefined;
  const title = known[error.code] ?? own ?? html`<span lang="en">${error.problem.title}</span>`;
  return { title, detail: error.problem.detail };
}

/**
 * The data of a resource, or its state. Loaded data stays while it is reloaded, and if that fails
 * the failure is shown above it.
 * @template Data
 * @param {{
 *   resource: import("../api/resource.js").Resource<Data>,
 *   children: (data: Data) => Children,
 *   lines?: number,
 *   back?: Children,
 * }} props
 */
export function loaded({ resource, children, lines, back }) {
  const { data, error, reload } = resource;
  const failure =
    error !== undefined && !(error instanceof OfflineError && data !== undefined)
      ? h(Failure, { error, retry: reload, retries: true, back })
      : null;
  if (data !== undefined) return h(Fragment, null, failure, children(data));
  return failure ?? h(Skeleton, lines === undefined ? {} : { lines });
}
