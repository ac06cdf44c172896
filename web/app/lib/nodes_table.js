// Tables of nodes and points, read by the server.

import { answer, api } from "../api/client.js";

/** @typedef {import("../api/client.js").Schema<"TableProposal">} Proposal */
/** @typedef {import("../api/client.js").Schema<"TableMapping">} Mapping */
/** @typedef {import("../api/client.js").Schema<"TableMeaning">} Meaning */
/** @typedef {import("../api/client.js").Schema<"TableUnit">} Unit */

/** Selectable meanings, and the units of each. */
export const UNITS_OF = /** @type {const} */ ({
  roll_length: ["mm", "um", "in"],
  diameter: ["mm", "um", "in"],
  roll_angle: ["deg", "arcmin", "rad"],
  face_width: ["mm", "um", "in"],
  deviation: ["um", "mm", "nm", "in"],
  u: [],
  v: [],
  x: ["mm", "um", "in"],
  y: ["mm", "um", "in"],
  z: ["mm", "um", "in"],
  i: [],
  j: [],
  k: [],
  weight: [],
  tooth: [],
  flank: [],
  trace: [],
  id: [],
  ignore: [],
});

/**
 * Returns the server's interpretation of a table, with the nodes of its first flank.
 * @param {Blob} file @param {Mapping | undefined} mapping @returns {Promise<Proposal>}
 */
export async function readTable(file, mapping) {
  const form = new FormData();
  form.append("file", file, "table");
  if (mapping) form.append("mapping", new Blob([JSON.stringify(mapping)], { type: "application/json" }));
  const { data } = await answer(
    api.POST("/v1/nodes/read", {
      params: { query: { include: ["nodes"] } },
      body: { file: "" },
      bodySerializer: () => form,
    }),
  );
  return data;
}

/** Returns the mapping of a proposal. @param {Proposal} proposal @returns {Mapping} */
export function mappingOf({ separator, decimal, header, matrix, columns }) {
  return { separator, decimal, header, matrix, columns };
}

/**
 * Returns the mapping with another meaning or unit of a column. A unit that does not belong to the
 * meaning is dropped; another column of the same meaning is ignored.
 * @param {Mapping} mapping @param {number} at @param {{ meaning?: Meaning, unit?: Unit }} change @returns {Mapping}
 */
export function withColumn(mapping, at, change) {
  const columns = (mapping.columns ?? []).map((column, k) => {
    if (k !== at) {
      const repeats = change.meaning === column.meaning && change.meaning !== "ignore";
      return repeats
        ? { ...(column.name ? { name: column.name } : {}), meaning: /** @type {const} */ ("ignore") }
        : column;
    }
    const meaning = change.meaning ?? column.meaning;
    const units = /** @type {readonly Unit[]} */ (UNITS_OF[meaning]);
    const unit = [change.unit, column.unit, units[0]].find((one) => one !== undefined && units.includes(one));
    return { ...(column.name ? { name: column.name } : {}), meaning, ...(unit ? { unit } : {}) };
  });
  return { ...mapping, columns };
}

/** Returns true if the columns name the places and heights of a flank. @param {Proposal | undefined} proposal */
export function namesAxes(proposal) {
  return proposal?.axes?.z !== undefined || proposal?.axes?.y !== undefined;
}
