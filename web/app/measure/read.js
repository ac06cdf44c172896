// The type and contents of a measurement file, before it is sent. Pure; runs in the worker.

import { gridOf } from "../flank/surface.js";
import { scatteredOf } from "../flank/triangles.js";
import { digestOf } from "../lib/digest.js";
import { isJson } from "../lib/nodes_file.js";

/** @typedef {import("../flank/surface.js").FlankSurface} FlankSurface */
/** @typedef {{ place: string, found: string }} Doubt a cell that is no number: `line 5, column 3` as the file counts */
/**
 * @typedef {object} Content
 * @property {"json" | "table" | "import" | "values"} kind how it is sent; `table`: read by the server first; `values`:
 *   printed values, which are not nodes
 * @property {string} form what it is: grid, scattered, curve, matrix, mka, points, rexs, mew
 * @property {number} nodes
 * @property {number} missing
 * @property {FlankSurface | undefined} surface
 * @property {Record<string, unknown> | undefined} request of JSON: all of it
 * @property {Doubt[]} doubts
 * @property {string} digest of the file
 * @property {string | undefined} failure why it cannot be read: `json`, `empty`, `columns`, `nodes`; with what the reader says
 * @property {string | undefined} detail
 * @property {import("../lib/nodes_table.js").Proposal | undefined} proposal of a table: what it is taken for
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
  failure: undefined,
  detail: undefined,
  proposal: undefined,
  ...given,
});

/** @param {string} name @param {Uint8Array} bytes @returns {Content} */
export function readFile(name, bytes) {
  return { ...contentOf(name, bytes), digest: digestOf(bytes) };
}

/** @param {string} name @param {Uint8Array} bytes @returns {Content} */
function contentOf(name, bytes) {
  const end = /\.(\w+)$/.exec(name.toLowerCase())?.[1] ?? "";
  if (bytes.length === 0) return content({ failure: "empty" });
  if (bytes[0] === 0x50 && bytes[1] === 0x4b) return content({ form: "rexs" });
  const text = new TextDecoder().decode(bytes).replace(/^\uFEFF/, "");
  const begin = text.slice(0, 4000);
  if (end === "mew" || /KS\.MW\.FILE/.test(begin)) return content({ kind: "values", form: "mew" });
  if (end === "mka" || /KS\.MK\.FILE/.test(begin)) return content({ form: "mka" });
  if (/^\s*</.test(begin)) return content({ form: "rexs" });
  if (isJson(begin)) return ofJson(text);
  return content({ kind: "table" });
}

/**
 * Adds the server's interpretation to a table.
 * @param {Content} table @param {import("../lib/nodes_table.js").Proposal} proposal @returns {Content}
 */
export function proposed(table, proposal) {
  const { layout, nodes, missing, read } = proposal;
  const counts = { nodes: nodes + missing, missing, proposal, request: undefined, surface: undefined };
  if (!layout) return { ...table, ...counts, kind: "table", form: "", failure: "columns" };
  if (layout === "points") return { ...table, ...counts, kind: "import", form: "points", failure: undefined };
  const { surface } = ofNodes(read);
  return { ...table, ...counts, kind: "table", form: layout, surface, failure: undefined };
}

/** @param {string} text */
function ofJson(text) {
  /** @type {any} */
  let value;
  try {
    value = JSON.parse(text);
  } catch (error) {
    return content({ kind: "json", failure: "json", detail: error instanceof Error ? error.message : "" });
  }
  const request = value?.nodes ? value : value?.type ? { nodes: value } : undefined;
  if (!request) return content({ kind: "json", failure: "nodes" });
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
