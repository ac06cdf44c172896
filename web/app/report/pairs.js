// Pairs of iterations of a report that are compared as before and after. Pure.

/** @typedef {import("./data.js").Told} Told */

/** Whether both are of the same flank of the same tooth. @param {Told} one @param {Told} other */
const alike = ({ iteration: one }, { iteration: other }) => one.flank === other.flank && one.tooth === other.tooth;

/** The last iteration of a report and the first of the same flank and tooth or, without one, the first of all. @param {readonly Told[]} told */
export function endsOf(told) {
  const last = told.at(-1);
  if (!last || told.length < 2) return told.slice(0, 1);
  const first = told.find((one) => one !== last && alike(one, last)) ?? told[0];
  return first ? [first, last] : [last];
}

/** Whether two iterations form a pair before and after. @param {readonly Told[]} told */
export function isPair([first, last]) {
  return first !== undefined && last !== undefined && alike(first, last);
}
