// Errors of requests.

/** @typedef {import("./client.js").Schema<"Problem">} Problem */

/** A refusal of the server: `application/problem+json`. */
export class ApiError extends Error {
  /** @param {Problem} problem @param {Response} response */
  constructor(problem, response) {
    super(problem.detail || problem.title);
    this.problem = problem;
    this.status = response.status;
    this.code = problem.code;
    this.requestId = problem.request_id ?? response.headers.get("x-request-id") ?? undefined;
    /** The seconds after which the server wants another try. @type {number | undefined} */
    this.retryAfter = seconds(response.headers.get("retry-after"));
  }

  /** Returns the errors outside of these pointers and everything below them. @param {readonly string[]} known */
  errorsElsewhere(known) {
    const errors = this.problem.errors ?? [];
    return errors.filter(({ pointer }) => !known.some((one) => pointer === one || pointer.startsWith(`${one}/`)));
  }
}

/** A request without a response. */
export class OfflineError extends Error {}

/**
 * Returns the errors at a pointer and below it.
 * @param {unknown} error @param {string} pointer
 */
export function errorsAt(error, pointer) {
  if (!(error instanceof ApiError)) return [];
  return (error.problem.errors ?? []).filter((one) => one.pointer === pointer || one.pointer.startsWith(`${pointer}/`));
}

/** Makes a problem of a response that is not problem+json. @param {Response} response @returns {Problem} */
export function unexplained(response) {
  const title = response.statusText || `HTTP ${response.status}`;
  return { type: "about:blank", title, status: response.status, code: "unexplained", detail: title };
}

/** @param {string | null} value */
function seconds(value) {
  if (value === null) return undefined;
  const number = Number(value);
  return Number.isFinite(number) && number >= 0 ? number : undefined;
}
