// What a file of a measurement is, and what is in it, before it is sent. Pure; runs in the worker.

import { gridOf } from "../flank/surface.js";
import { scatteredOf } from "../flank/triangles.js";
import { digestOf } from "../lib/digest.js";
import { gridOfTable, headerOf, readNodesCsv } from "../lib/nodes_csv.js";

/** @typedef {import("../flank/surface.js").FlankSurface} FlankSurface */
/** @typedef {{ place: string, found: string }} Doubt a cell that is no number: `line 5, column 3` as the file counts */
/**
 * @typedef {object} Content
 * @property {"json" | "csv" | "import" | "values"} kind how it is sent; `values`: printed values, which are not nodes
 * @property {string} form what it is: grid, scattered, curve, matrix, mka, points, rexs, mew
 * @property {number} nodes
 * @property {number} missing
 * @property {FlankSurface | undefined} surface
 * @property {Record<string, unknown> | undefined} request of JSON: all of it
 * @property {Doubt[]} doubts
 * @property {string} digest of the file
 * @property {string | undefined} fault why it cannot be read: `json`, `empty`, `header`, `nodes`; with what the reader says
 * @property {string | undefined} detail
 */

/** @param {Partial<Content>} [given] @returns {Content} */
const content = (given) => ({
  kind: "import",
  form: "",
  nodes: 0,
  missing: 0,
  surface: undefined,
  request: undefined,
  doubts: [],
  digest: "",
  fault: undefined,
  detail: undefined,
  ...given,
});

/** @param {string} name @param {Uint8Array} bytes @returns {Content} */
export function readFile(name, bytes) {
  return { ...contentOf(name, bytes), digest: digestOf(bytes) };
}

/** @param {string} name @param {Uint8Array} bytes @returns {Content} */
function contentOf(name, bytes) {
  const end = /\.(\w+)$/.exec(name.toLowerCase())?.[1] ?? "";
  if (bytes.length === 0) return content({ fault: "empty" });
  if (bytes[0] === 0x50 && bytes[1] === 0x4b) return content({ form: "rexs" });
  const text = new TextDecoder().decode(bytes).replace(/^\uFEFF/, "");
  const begin = text.slice(0, 4000);
  if (end === "mew" || /KS\.MW\.FILE/.test(begin)) return content({ kind: "values", form: "mew" });
  if (end === "mka" || /KS\.MK\.FILE/.test(begin)) return content({ form: "mka" });
  if (/^\s*</.test(begin)) return content({ form: "rexs" });
  if (/^\s*[{[]/.test(begin)) return ofJson(text);
  const header = headerOf(begin);
  if (/^id,x,y,z/i.test(header)) return content({ form: "points", nodes: lines(text) - 1 });
  const table = readNodesCsv(text);
  return table ? ofTable(table) : content({ kind: "csv", fault: "header", detail: header.slice(0, 80) });
}

/** @param {string} text */
const lines = (text) => text.split(/\r?\n/).filter((line) => line.trim() !== "").length;

/** @param {string} text */
function ofJson(text) {
  /** @type {any} */
  let value;
  try {
    value = JSON.parse(text);
  } catch (error) {
    return content({ kind: "json", fault: "json", detail: error instanceof Error ? error.message : "" });
  }
  const request = value?.nodes ? value : value?.type ? { nodes: value } : undefined;
  if (!request) return content({ kind: "json", fault: "nodes" });
  return content({ kind: "json", request, ...ofNodes(request.nodes) });
}

/** @param {any} nodes @returns {Partial<Content>} */
function ofNodes(nodes) {
  const form = String(nodes?.type ?? "");
  const list = (/** @type {unknown} */ one) => (Array.isArray(one) ? one : []);
  /** @type {Doubt[]} */
  const doubts = [];
  const doubtful = (/** @type {unknown} */ value, /** @type {string} */ place) => {
    if (value !== null && typeof value !== "number" && doubts.length < 100)
      doubts.push({ place, found: JSON.stringify(value) ?? "" });
  };
  if (form === "grid") {
    const [u, v, z] = [list(nodes.u), list(nodes.v), list(nodes.z)];
    for (const [i, row] of z.entries())
      for (const [j, value] of list(row).entries()) doubtful(value, `/nodes/z/${i}/${j}`);
    const surface = gridOf(u.map(Number), v.map(Number), z.map(list), nodes.valid);
    return { form, doubts, surface, nodes: surface.z.length, missing: count(surface.z) };
  }
  if (form === "scattered") {
    const [u, v, z] = [list(nodes.u), list(nodes.v), list(nodes.z)];
    for (const [i, value] of z.entries()) doubtful(value, `/nodes/z/${i}`);
    const heights = z.map((value) => (typeof value === "number" ? value : Number.NaN));
    return { form, doubts, surface: scatteredOf(u.map(Number), v.map(Number), heights), nodes: z.length };
  }
  const y = list(nodes?.y);
  for (const [i, value] of y.entries()) doubtful(value, `/nodes/y/${i}`);
  return { form, doubts, nodes: y.length };
}

/** @param {Float64Array} values */
function count(values) {
  let missing = 0;
  for (const value of values) if (Number.isNaN(value)) missing += 1;
  return missing;
}

/** A table that forms a grid is sent as a grid; a faulty one is sent unchanged, so that the server can name the lines. @param {import("../lib/nodes_csv.js").NodesTable} table */
function ofTable(table) {
  const { columns, count: nodes, missing, doubts: found } = table;
  const { u, v, z } = columns;
  const grid = gridOfTable(table);
  const doubts = found.map(({ line, column, found: cell }) => ({ place: `${line}:${column}`, found: cell }));
  if (grid && doubts.length === 0) return content({ kind: "json", request: { nodes: grid }, ...ofNodes(grid) });
  const surface = grid ? gridOf(grid.u, grid.v, grid.z) : u && v && z ? scatteredOf(u, v, z) : undefined;
  return content({ kind: "csv", form: surface ? surface.kind : "curve", nodes, missing, surface, doubts });
}
