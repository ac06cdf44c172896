// Pairs of iterations of a report that are compared as before and after. Pure.

/** @typedef {import("./data.js").ReportData} ReportData */

/** Returns true if both are of the same flank of the same tooth. @param {ReportData} one @param {ReportData} other */
const alike = ({ iteration: one }, { iteration: other }) => one.flank === other.flank && one.tooth === other.tooth;

/** Returns the last iteration of a report and the first of the same flank and tooth or, without one, the first of all. @param {readonly ReportData[]} data */
export function endsOf(data) {
  const last = data.at(-1);
  if (!last || data.length < 2) return data.slice(0, 1);
  const first = data.find((one) => one !== last && alike(one, last)) ?? data[0];
  return first ? [first, last] : [last];
}

/** Returns true if two iterations form a pair before and after. @param {readonly ReportData[]} data */
export function isPair([first, last]) {
  return first !== undefined && last !== undefined && alike(first, last);
}
