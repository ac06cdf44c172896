// The story of a job as entries in the order of time. Pure functions.

/** @typedef {import("../api/job.js").TracedIteration} TracedIteration */
/** @typedef {TracedIteration["fits"][number]} TracedFit */
/**
 * @typedef {{ id: string, time: string, iteration: number } & (
 *   | { kind: "measured", correction: string | undefined, correctionOf: number | undefined }
 *   | { kind: "fit", fit: TracedFit }
 *   | { kind: "choice", fit: TracedFit | undefined, until: string | undefined, reason: string | undefined, by: string | undefined }
 *   | { kind: "record", record: NonNullable<TracedIteration["records"]>[number] }
 *   | { kind: "decision", decision: string, concession: boolean, reason: string | undefined, by: string | undefined }
 * )} Entry
 */
/** @typedef {Entry["kind"]} Kind */

/** The order of kinds at equal times. @type {readonly Kind[]} */
export const KINDS = ["measured", "fit", "choice", "record", "decision"];

/** @param {readonly TracedIteration[]} iterations @returns {Entry[]} */
export function entriesOf(iterations) {
  const measured = measuredCorrections(iterations);
  const all = iterations.flatMap((one) => ofIteration(one, measured.get(one.number)));
  return all.sort(
    (a, b) =>
      Date.parse(a.time) - Date.parse(b.time) ||
      a.iteration - b.iteration ||
      KINDS.indexOf(a.kind) - KINDS.indexOf(b.kind),
  );
}

/** @param {TracedIteration} one @param {{ id: string, iteration: number } | undefined} correction @returns {Entry[]} */
function ofIteration(one, correction) {
  const iteration = one.number;
  const fits = new Map(one.fits.map((fit) => [fit.id, fit]));
  return [
    {
      id: one.id,
      kind: "measured",
      time: one.created_at,
      iteration,
      correction: correction?.id,
      correctionOf: correction?.iteration,
    },
    ...one.fits.map((fit) => /** @type {Entry} */ ({ id: fit.id, kind: "fit", time: fit.created_at, iteration, fit })),
    ...one.choices.map(
      ({ fit_id, reason, created_at, by }, i) =>
        /** @type {Entry} */ ({
          id: `choice-${iteration}-${i}`,
          kind: "choice",
          time: created_at,
          until: one.choices[i + 1]?.created_at,
          iteration,
          fit: fits.get(fit_id),
          reason,
          by,
        }),
    ),
    ...(one.records ?? []).map(
      (record) => /** @type {Entry} */ ({ id: record.id, kind: "record", time: record.created_at, iteration, record }),
    ),
    ...one.decisions.map(
      ({ decision, concession, reason, created_at, by }, i) =>
        /** @type {Entry} */ ({
          id: `decision-${iteration}-${i}`,
          kind: "decision",
          time: created_at,
          iteration,
          decision,
          concession: concession === true,
          reason,
          by,
        }),
    ),
  ];
}

/**
 * Returns the correction that an iteration measured: the last one of earlier iterations of the same
 * flank and tooth that was made before it and that no other iteration has measured.
 * @param {readonly TracedIteration[]} iterations
 */
function measuredCorrections(iterations) {
  /** @type {Map<number, { id: string, iteration: number }>} */
  const found = new Map();
  for (const [i, one] of iterations.entries()) {
    const before = iterations.slice(0, i).findLast(({ flank, tooth }) => flank === one.flank && tooth === one.tooth);
    const correction = before?.records?.findLast(
      ({ kind, created_at }) => kind === "correction" && Date.parse(created_at) <= Date.parse(one.created_at),
    );
    if (before && correction) found.set(one.number, { id: correction.id, iteration: before.number });
  }
  return found;
}

/**
 * Compares two fits, coefficient by coefficient.
 * @param {TracedFit} a @param {TracedFit} b @param {boolean} sameNodes
 */
export function compared(a, b, sameNodes) {
  const others = new Map(b.coefficients.map((one) => [one.term, one]));
  return a.coefficients.flatMap((one) => {
    const other = others.get(one.term);
    if (!other) return [];
    const error = sameNodes ? one.std_error : Math.hypot(one.std_error ?? Number.NaN, other.std_error ?? Number.NaN);
    const difference = other.value - one.value;
    const inErrors = error && error > 0 ? difference / error : undefined;
    return [{ term: one.term, a: one, b: other, difference, inErrors }];
  });
}
