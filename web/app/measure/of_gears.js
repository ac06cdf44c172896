// The contents of a file of a tester or of a gear program, before anything is sent: its gears, its
// traces, its printed values.

import { GearSymbol } from "../components/symbol.js";
import { table } from "../components/table.js";
import { WarningList } from "../components/warnings.js";
import de from "../i18n/de/measure.js";
import en from "../i18n/en/measure.js";
import { fmt, texts } from "../i18n/i18n.js";
import { ABSENT } from "../lib/format.js";
import { gearInShort } from "../lib/gear.js";
import { h, html } from "../../vendor/ui.js";

const t = texts({ en, de });

/** @typedef {import("../api/client.js").Schema<"GearsOfFile">} GearsOfFile */
/** @typedef {import("../api/client.js").Schema<"FileTrace">} FileTrace */
/** @typedef {import("../api/client.js").Schema<"FileValue">} FileValue */
/** @template Row @typedef {import("../components/table.js").Column<Row>} Column */

/** @param {{ file: GearsOfFile, name: string }} props `name`: of the file */
export function OfGears({ file, name }) {
  const { gears, traces = [], pitches = [], values = [], warnings } = file;
  return html`<ul class="gears">${gears.map((gear, i) => html`<li key=${i}>${gearText(gear)}</li>`)}</ul>
    ${traces.length > 0 && h(Traces, { traces, name })}
    ${pitches.length > 0 && html`<p class="gears-pitches">${t.pitchesOf(pitches.map((flank) => t[flank]).join(", "))}</p>`}
    ${values.length > 0 && h(Values, { values, name })}
    ${warnings.length > 0 && h(WarningList, { warnings })}`;
}

/** A gear in short, and the flanks that have a topography. @param {GearsOfFile["gears"][number]} gear */
function gearText({ id, name, gear, topographies = [] }) {
  const data = [id, name, gearInShort(gear)].filter(Boolean).join(" · ");
  return html`<span translate="no">${data}</span>${topographies.length > 0 && html` · ${t.topographiesOf(topographies.map((flank) => t[flank]).join(", "))}`}`;
}

/** @param {string} text */
const data = (text) => html`<span translate="no">${text}</span>`;

/** @param {{ traces: readonly FileTrace[], name: string }} props */
function Traces({ traces, name }) {
  const count = (/** @type {"samples" | "undefined"} */ key, /** @type {string} */ header) =>
    /** @type {Column<FileTrace>} */ ({
      key,
      header,
      numeric: true,
      cell: (one) => data(fmt.value.count(one[key])),
      csv: (one) => one[key],
    });
  const flanks = new Set(traces.map(({ tooth, flank }) => `${/^\d*/.exec(tooth)?.[0] || tooth} ${flank}`));
  return table({
    caption: t.tracesOf(traces.length, flanks.size),
    csvName: `${name} traces`,
    stacked: true,
    rows: traces,
    rowKey: ({ line }) => line,
    note: t.tracesNote,
    columns: [
      { key: "tooth", header: t.tooth, rowHeader: true, cell: ({ tooth }) => data(tooth), csv: ({ tooth }) => tooth },
      { key: "flank", header: t.flank, cell: ({ flank }) => t[flank], csv: ({ flank }) => t[flank] },
      { key: "kind", header: t.traceKind, cell: ({ kind }) => t[kind], csv: ({ kind }) => kind },
      { key: "section", header: t.section, cell: (trace) => sectionOf(trace) },
      count("samples", t.samples),
      count("undefined", t.missing),
      { key: "z", header: "z", unit: "mm", csv: (trace) => trace.section_z_mm },
      { key: "diameter", header: t.diameter, unit: "mm", csv: (trace) => trace.section_diameter_mm },
      { key: "roll", header: t.rollLength, unit: "mm", csv: (trace) => trace.section_roll_length_mm },
    ],
  });
}

/** The position of a trace, as in the file. @param {FileTrace} trace */
function sectionOf({ section_z_mm: z, section_diameter_mm: diameter, section_roll_length_mm: roll }) {
  if (z !== undefined) return data(`z ${fmt.value.mm(z)}\u202fmm`);
  if (diameter !== undefined) return html`${t.diameter} ${data(`${fmt.value.mm(diameter)}\u202fmm`)}`;
  if (roll !== undefined) return html`${t.rollLength} ${data(`${fmt.value.mm(roll)}\u202fmm`)}`;
  return ABSENT;
}

/** @param {{ values: readonly FileValue[], name: string }} props */
function Values({ values, name }) {
  return table({
    caption: t.printedValues(values.length),
    csvName: `${name} values`,
    stacked: true,
    rows: values,
    rowKey: ({ line }) => line,
    columns: [
      { key: "name", header: t.printed, rowHeader: true, cell: (one) => data(one.name), csv: (one) => one.name },
      {
        key: "symbol",
        header: t.symbol,
        cell: ({ characteristic: of }) => (of ? h(GearSymbol, { name: symbolOf(of) }) : ABSENT),
        csv: ({ characteristic }) => characteristic,
      },
      { key: "code", header: t.code, csv: ({ code }) => code },
      {
        key: "flank",
        header: t.flank,
        cell: ({ flank }) => (flank ? t[flank] : ABSENT),
        csv: ({ flank }) => flank && t[flank],
      },
      { key: "of", header: t.ofTeeth, cell: (one) => whose(one), csv: ({ tooth, statistic }) => tooth ?? statistic },
      { key: "position", header: t.position, csv: ({ position }) => position },
      {
        key: "value",
        header: t.value,
        numeric: true,
        cell: (one) => writtenOf(one),
        csv: ({ value }) => value,
      },
      { key: "unit", header: t.unit, csv: ({ unit }) => unit },
      { key: "state", header: t.state, csv: ({ state }) => state },
    ],
  });
}

/** @param {FileValue} one */
function whose({ tooth, statistic, position }) {
  const of = tooth ? html`${t.tooth} ${data(tooth)}` : t[`statistic_${statistic}`];
  return position === "middle" ? of : html`${of}, ${t[`position_${position}`]}`;
}

/** @param {FileValue} one */
function writtenOf({ value, unit, state }) {
  if (value === undefined) return state === "measured" ? ABSENT : t[state];
  const written =
    unit === "um"
      ? `${fmt.value.um(value)}\u202fµm`
      : unit === "mm"
        ? `${fmt.value.mm(value)}\u202fmm`
        : fmt.value.three(value);
  return data(written);
}

/** Formats `f_Halpha` with its Greek index. @param {string} name */
const symbolOf = (name) => name.replace(/alpha/i, "α").replace(/beta/i, "β");
