// The nodes of a map as a table.

import { table } from "../components/table.js";
import { t } from "../i18n/flank.js";
import { fmt } from "../i18n/i18n.js";
import { html } from "../../vendor/ui.js";
import { scaleFor } from "./scale.js";
import { boxOf, nodeOf } from "./surface.js";

/** @typedef {import("./surface.js").FlankSurface} FlankSurface */
/** @typedef {import("./surface.js").FlankNode} FlankNode */

/** Rows of the table, as of sections: more than anybody reads, and few enough to draw at once. The file has all. */
const MOST_ROWS = 2000;

/**
 * @param {{ surface: FlankSurface, title: string, name: string, unit: string | undefined, axes: import("./heat_map.js").MapAxes, csvName: string }} props
 *   `title`: of the heights; `name`: of the table
 */
export function MapTable({ surface, title, name, unit, axes, csvName }) {
  const count = surface.z.length;
  const whole = boxOf(surface);
  const { limit } = scaleFor(surface);
  const nodes = (/** @type {number} */ most) => Array.from({ length: most }, (_, i) => nodeOf(surface, i));
  /** @param {"u" | "v"} key @returns {import("../components/table.js").Column<FlankNode>} */
  const place = (key) => ({
    key,
    header: axes[key].label,
    unit: axes[key].unit,
    numeric: true,
    cell: (node) =>
      html`<span translate="no">${fmt.value.onScale(node[key], whole[key][1] - whole[key][0], "mm")}</span>`,
    csv: (node) => node[key],
  });
  return table({
    caption: name,
    hideCaption: true,
    csvName,
    rows: nodes(Math.min(count, MOST_ROWS)),
    fileRows: () => nodes(count),
    rowKey: ({ index }) => index,
    note: count > MOST_ROWS ? t.firstNodes(fmt.value.count(MOST_ROWS), fmt.value.count(count)) : undefined,
    columns: [
      place("u"),
      place("v"),
      {
        key: "z",
        header: title,
        unit,
        numeric: true,
        cell: ({ z }) =>
          Number.isNaN(z) ? t.missing : html`<span translate="no">${fmt.value.onScale(z, limit, unit)}</span>`,
        csv: ({ z }) => z,
      },
    ],
  });
}
