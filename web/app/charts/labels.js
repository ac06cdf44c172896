// Labels of places along x that do not overlap: rows for them.

/** Estimates the width of a label in a chart, in pixels. @param {string} text */
export const labelWidth = (text) => 6.8 * text.length + 10;

/**
 * Joins labels at the same place, and gives each label the first free row.
 * @param {readonly { x: number, label: string }[]} marks places in pixels @param {number} width of the plot
 * @returns {{ x: number, label: string, row: number, end: boolean }[]} `end`: the label ends at its place
 */
export function rowsOfLabels(marks, width) {
  /** @type {{ x: number, label: string }[]} */
  const joined = [];
  for (const mark of [...marks].sort((a, b) => a.x - b.x)) {
    const last = joined.at(-1);
    if (last && mark.x - last.x < 2) last.label += `, ${mark.label}`;
    else joined.push({ ...mark });
  }
  /** @type {[number, number][][]} */
  const rows = [];
  return joined.map(({ x, label }) => {
    const size = labelWidth(label);
    const end = x + size > width;
    const [from, to] = end ? [x - size, x] : [x, x + size];
    let row = rows.findIndex((taken) => taken.every(([a, b]) => to <= a || from >= b));
    if (row < 0) row = rows.push([]) - 1;
    rows[row]?.push([from, to]);
    return { x, label, row, end };
  });
}
