// Nodes as a text: JSON (nodes alone, or a request with them). Pure. The server validates, and
// reads tables; here only the drawn and counted data is read.

/** @typedef {import("../api/client.js").Schema<"Nodes">} Nodes */
/** @typedef {Record<string, unknown>} Fields */
/**
 * @typedef {object} NodesFile
 * @property {Nodes} nodes missing heights are NaN or null
 * @property {string} text as it was given
 * @property {Fields} spec what a request says of the fit
 * @property {Fields} measurement what it says of the measurement
 * @property {number} count nodes, missing ones included
 * @property {number} missing
 */
/** @typedef {"empty" | "json" | "noNodes"} NodesFailure */

/** Fields of an iteration that a fit does not have. */
const MEASUREMENT = ["measured_at", "instrument", "operator", "note"];
const TYPES = ["curve", "grid", "scattered", "matrix"];

/** @param {string} given @returns {{ file: NodesFile, failure?: undefined } | { failure: NodesFailure, file?: undefined }} */
export function readNodes(given) {
  const text = given.replace(/^\uFEFF/, "");
  if (text.trim() === "") return { failure: "empty" };
  return ofJson(text);
}

/** Returns true if a text is JSON; anything else is a table, which may begin with a block `[A]`. @param {string} text */
export function isJson(text) {
  return /^\uFEFF?\s*(\{|\[\s*[[{"\d\-\]])/.test(text);
}

/** Returns a table that the server has read as JSON. @param {import("./nodes_table.js").Proposal} proposal */
export function textOfTable({ read, axes, flanks }) {
  const [first] = flanks ?? [];
  const { flank, tooth } = first ?? {};
  return JSON.stringify({
    nodes: read,
    ...(axes ? { axes } : {}),
    ...(flank ? { flank } : {}),
    ...(tooth ? { tooth } : {}),
  });
}

/** @param {string} text @returns {ReturnType<typeof readNodes>} */
function ofJson(text) {
  /** @type {any} */
  let value;
  try {
    value = JSON.parse(text);
  } catch {
    return { failure: "json" };
  }
  const request = TYPES.includes(value?.type) ? { nodes: value } : value;
  if (!TYPES.includes(request?.nodes?.type)) return { failure: "noNodes" };
  /** @type {Fields} */
  const spec = {};
  /** @type {Fields} */
  const measurement = {};
  for (const [name, one] of Object.entries(request)) {
    if (name === "nodes") continue;
    if (MEASUREMENT.includes(name)) measurement[name] = one;
    else spec[name] = one;
  }
  return { file: { nodes: request.nodes, text, spec, measurement, ...counted(request.nodes) } };
}

/** @param {any} nodes not validated yet */
function counted({ type, z, y, valid }) {
  const heights = type === "curve" || type === "matrix" ? y : z;
  let [count, missing] = [0, 0];
  const take = (/** @type {unknown} */ height, /** @type {unknown} */ counts) => {
    count += 1;
    if (counts === false || typeof height !== "number" || Number.isNaN(height)) missing += 1;
  };
  for (const [i, one] of list(heights).entries()) {
    if (type === "grid") for (const [j, height] of list(one).entries()) take(height, valid?.[i]?.[j]);
    else take(one, valid?.[i]);
  }
  return { count, missing };
}

/** @param {unknown} value @returns {unknown[]} */
const list = (value) => (Array.isArray(value) ? value : []);

/**
 * Returns the spec of a fit: the file's own with the choices made here.
 * @param {NodesFile} file @param {{ degree?: string | undefined, by?: string | undefined }} chosen
 * @returns {Fields}
 */
export function specOf({ nodes, spec }, { degree, by }) {
  const n = Number(degree) || 2;
  const named = "model" in spec && !degree;
  const columns = nodes.type === "matrix" ? { type: "linear" } : undefined;
  const curve = nodes.type === "curve";
  const polynomial = {
    type: "polynomial",
    degree: curve ? n : [n, n],
    basis: "legendre",
    // the surface of second order, of which slopes, crownings and twist are
    ...(curve || degree ? {} : { terms: "total" }),
  };
  /** @type {Fields} */
  const made = { ...spec, model: named ? spec["model"] : (columns ?? polynomial) };
  if (by === "none") made["regularization"] = { type: "none" };
  else if (by) {
    const own = /** @type {{ type?: string } | undefined} */ (spec["regularization"]);
    made["regularization"] = {
      ...(own?.type === "spectral" ? own : { type: "spectral" }),
      lambda_star: { criterion: by },
    };
  }
  const include = Array.isArray(spec["include"]) ? spec["include"] : [];
  made["include"] = [...new Set([...include, "residuals", "fitted", "intervals"])];
  return made;
}
