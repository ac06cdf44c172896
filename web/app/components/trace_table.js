// The samples of a trace as a table.

import { t } from "../i18n/evaluation.js";
import { t as flankText } from "../i18n/flank.js";
import { fmt } from "../i18n/i18n.js";
import { ABSENT } from "../lib/format.js";
import { outsideBy } from "../lib/traces.js";
import { html } from "../../vendor/ui.js";
import { table } from "./table.js";

/** @typedef {import("../lib/traces.js").Sample} Sample */
/** @typedef {Sample & { key: number, outside: number }} Row */

/**
 * @param {{ trace: import("../lib/traces.js").GearTrace, sheet: import("../lib/traces.js").Sheet, bands: readonly import("../lib/traces.js").DrawnBand[],
 *   rolled: boolean, name: string }} props `rolled`: diameters have become roll lengths, as the gear is known
 */
export function TraceTable({ trace, sheet, bands, rolled, name }) {
  const along = trace.kind === "helix" ? "face_width" : trace.roll_length_mm || rolled ? "roll_length" : "diameter";
  const rows = sheet.samples.map((sample, key) => {
    const outsides = bands.map(({ limits }) => outsideBy(sample, limits[key]));
    const outside = outsides.reduce((most, one) => (Math.abs(one) > Math.abs(most) ? one : most), 0);
    return { ...sample, key, outside };
  });
  /** @param {string} key @param {string} header @param {(row: Row) => number | null} value @returns {import("./table.js").Column<Row>} */
  const um = (key, header, value) => ({
    key,
    header,
    unit: "µm",
    numeric: true,
    cell: (row) => {
      const of = value(row);
      return of === null ? ABSENT : html`<span translate="no">${fmt.value.um(of)}</span>`;
    },
    csv: value,
  });
  return table({
    caption: name,
    hideCaption: true,
    csvName: name,
    rows,
    rowKey: ({ key }) => key,
    columns: /** @type {import("./table.js").Column<Row>[]} */ ([
      {
        key: "at",
        header: flankText[along],
        unit: "mm",
        numeric: true,
        cell: ({ at }) => html`<span translate="no">${fmt.value.mm(at)}</span>`,
        csv: ({ at }) => at,
      },
      um("value", flankText.deviation, ({ value }) => value),
      ...(rows.some(({ design }) => design !== 0) ? [um("design", t.design, ({ design }) => design)] : []),
      { key: "inside", header: t.inRange, cell: ({ inside }) => (inside ? t.yes : t.no), csv: ({ inside }) => inside },
      ...(bands.length > 0 ? [um("outside", t.outsideBand, ({ outside }) => (outside === 0 ? null : outside))] : []),
    ]),
  });
}
