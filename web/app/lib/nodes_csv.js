// Nodes as CSV: a header `u,v,z` or `x,y`, then `weight` if there are weights, one node a line. The
// one reader of it; what a number may be is the server's to say. Pure.

/**
 * @typedef {object} NodesTable
 * @property {readonly string[]} header
 * @property {Record<string, number[]>} columns by their names; NaN where a cell is empty or no number
 * @property {number} count nodes
 * @property {number} missing nodes without a height
 * @property {{ line: number, column: number, found: string }[]} doubts cells that are no numbers, as the file counts
 */

const HEADER = /^(u,v,z|x,y)(,weight)?$/;
const MOST_DOUBTS = 100;

/** @param {string} line */
const cellsOf = (line) => line.split(",").map((cell) => cell.trim().replace(/^"(.*)"$/, "$1"));

/** The header of a text, whatever it is. @param {string} text */
export function headerOf(text) {
  const line = /^\s*([^\r\n]*)/.exec(text.replace(/^\uFEFF/, ""))?.[1] ?? "";
  return cellsOf(line).join(",");
}

/** @param {string} text @returns {NodesTable | undefined} none where the header is another one */
export function readNodesCsv(text) {
  const found = headerOf(text);
  if (!HEADER.test(found)) return undefined;
  const header = found.split(",");
  const height = header[0] === "u" ? "z" : "y";
  const columns = header.map(() => /** @type {number[]} */ ([]));
  /** @type {NodesTable["doubts"]} */
  const doubts = [];
  let read = false;
  for (const [i, line] of text.split(/\r\n|\n|\r/).entries()) {
    if (line.trim() === "") continue;
    if (!read) {
      read = true;
      continue;
    }
    const row = cellsOf(line);
    for (const [j, name] of header.entries()) {
      const cell = row[j] ?? "";
      const value = cell === "" ? Number.NaN : Number(cell);
      columns[j]?.push(value);
      const told = cell === "" && (name === height || name === "weight");
      if (Number.isNaN(value) && !told && doubts.length < MOST_DOUBTS)
        doubts.push({ line: i + 1, column: j + 1, found: cell });
    }
  }
  const named = Object.fromEntries(header.map((name, j) => [name, columns[j] ?? []]));
  const heights = named[height] ?? [];
  const missing = heights.filter(Number.isNaN).length;
  return { header, columns: named, count: heights.length, missing, doubts };
}

/** A grid has at least this share of its nodes: in a table of scattered ones hardly two have a u or a v in common. */
const LEAST_SHARE = 0.8;

/**
 * The nodes of a table as a grid, where they stand on the crossings of a few u and v and none stands twice. A crossing
 * that the table leaves out is a missing node.
 * @param {NodesTable} table
 * @returns {import("../api/client.js").Schema<"GridNodes"> | undefined}
 */
export function gridOfTable({ columns: { u, v, z, weight } }) {
  if (!u || !v || !z) return undefined;
  const [us, vs] = [ascending(u), ascending(v)];
  if (us.length < 2 || vs.length < 2 || z.length < LEAST_SHARE * us.length * vs.length) return undefined;
  const [rowOf, columnOf] = [new Map(us.map((at, i) => [at, i])), new Map(vs.map((at, j) => [at, j]))];
  const rows = us.map(() => /** @type {(number | null)[]} */ (vs.map(() => null)));
  const weights = us.map(() => vs.map(() => 1));
  const taken = new Uint8Array(us.length * vs.length);
  for (const [k, height] of z.entries()) {
    const [i, j] = [rowOf.get(u[k] ?? Number.NaN), columnOf.get(v[k] ?? Number.NaN)];
    if (i === undefined || j === undefined || taken[i * vs.length + j]) return undefined;
    taken[i * vs.length + j] = 1;
    const [row, weighted] = [rows[i], weights[i]];
    if (row && !Number.isNaN(height)) row[j] = height;
    const of = weight?.[k] ?? 1;
    if (weighted) weighted[j] = Number.isNaN(of) ? 1 : of;
  }
  return { type: "grid", u: us, v: vs, z: rows, ...(weight ? { weight: weights } : {}) };
}

/** @param {readonly number[]} values */
const ascending = (values) => [...new Set(values)].filter((value) => !Number.isNaN(value)).sort((a, b) => a - b);
