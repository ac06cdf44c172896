// The deviations of all teeth: a small map of each flank on one scale, their sections over each other, one of them large.

import { answer, api } from "../api/client.js";
import { useResource } from "../api/resource.js";
import { Chart } from "../charts/chart.js";
import { Line, Rule } from "../charts/marks.js";
import { loaded } from "../components/states.js";
import { table } from "../components/table.js";
import { t } from "../i18n/flank.js";
import { fmt } from "../i18n/i18n.js";
import { dashOf, niceAbove } from "../lib/colour.js";
import { query, setQuery } from "../navigation.js";
import { h, html, useLayoutEffect, useMemo } from "../../vendor/ui.js";
import { mapAxes } from "./axes.js";
import { HeatMap } from "./heat_map.js";
import { Legend } from "./legend.js";
import { commonScale } from "./scale.js";
import { countsOf, sectionOf } from "./surface.js";
import { commonRange, flanksOf, inFigures } from "./teeth.js";
import { FlankView } from "./view.js";

/** @typedef {import("./teeth.js").ToothFlank} ToothFlank */
/** @typedef {import("./teeth.js").GearDeviations} GearDeviations */
/** @typedef {import("../api/client.js").Schema<"Axes">} Axes */

/** Deviations as the interface returns them. @type {Axes} */
const AXES = {
  u: { quantity: "roll_length", unit: "mm" },
  v: { quantity: "face_width", unit: "mm" },
  z: { quantity: "deviation", unit: "um", positive: "material_out" },
};

/** The maximum number of records in the layer: the last ones. */
export const MOST_RECORDS = 200;

/**
 * @param {{ jobId: string, number: number, records: readonly string[], name: string, flipU: boolean, file: string,
 *   onShown: () => void }} props `records`: ids of the deviations that were kept, in the order of time; `onShown`: all are there
 */
export function AllTeeth({ jobId, number, records, name, flipU, file, onShown }) {
  const ids = records.slice(-MOST_RECORDS);
  const resource = useResource(`deviations ${jobId} ${number} ${ids.join(" ")}`, async (signal) => {
    /** @type {GearDeviations[]} */
    const results = [];
    for (const id of ids) {
      const params = { path: { job_id: jobId, number, record_id: id } };
      const path = "/v1/jobs/{job_id}/iterations/{number}/records/{record_id}";
      const { data } = await answer(api.GET(path, { signal, params }));
      const { result } = /** @type {import("../api/client.js").Schema<"JobRecord">} */ (data);
      results.push(/** @type {GearDeviations} */ (/** @type {unknown} */ (result)));
    }
    return { data: flanksOf(results) };
  });
  const there = resource.data !== undefined || resource.error !== undefined;
  useLayoutEffect(() => {
    if (there) onShown();
  }, [there]);
  return loaded({
    resource,
    // the content below does not move into view and out again
    lines: 36,
    children: (flanks) =>
      flanks.length === 0
        ? html`<p class="quiet">${t.noTeeth}</p>`
        : h(Teeth, { flanks, name, flipU, file, more: records.length > ids.length }),
  });
}

/** @param {{ flanks: readonly ToothFlank[], name: string, flipU: boolean, file: string, more: boolean }} props */
function Teeth({ flanks, name, flipU, file, more }) {
  const picked = flanks.find(({ key }) => key === query.value.get("tooth")) ?? flanks[0];
  const scale = useMemo(() => commonScale(flanks.map(({ surface }) => surface)), [flanks]);
  const height = (/** @type {number | undefined} */ z) => fmt.value.onScale(z, scale.limit, "µm");
  const missing = flanks.reduce((sum, { surface }) => sum + countsOf(surface).missing, 0);
  if (!picked) return null;
  const axes = mapAxes(AXES);
  return html`<div class="all-teeth">
    <p class="quiet">${t.teethSummary(flanks.length, new Set(flanks.map(({ tooth }) => tooth)).size)}${more && ` ${t.lastRecords(MOST_RECORDS)}`}</p>
    <div class="teeth-maps">
      ${flanks.map((of) => {
        const { least, greatest } = inFigures(of);
        const [title, said] = [nameOf(of), t.fromTo(height(least), height(greatest))];
        return html`<button key=${of.key} type="button" class="tooth-map" aria-pressed=${of === picked}
          onClick=${() => setQuery({ tooth: of.key }, { step: true })}>
          <b>${title}</b>
          ${h(HeatMap, { name: title, summary: said, surface: of.surface, limit: scale.limit, unit: "µm", axes, flipU, small: true })}
          <span class="quiet" translate="no">${said}</span>
        </button>`;
      })}
    </div>
    ${h(Legend, { limit: scale.limit, unit: "µm", clipped: scale.clipped, missing })}
    <div class="flank-layout">
      ${h(Sections, { kind: "profile", flanks, picked, file })} ${h(Sections, { kind: "helix", flanks, picked, file })}
    </div>
    ${h(TeethTable, { flanks, file, height })}
    <h3>${nameOf(picked)}</h3>
    ${h(FlankView, { key: picked.key, surface: picked.surface, title: t.deviation, name: `${name}, ${nameOf(picked)}`, unit: "µm", axes: AXES, flipU, atLeast: scale.limit, file: `${file}-${picked.key}` })}
  </div>`;
}

/** @param {ToothFlank} of */
const nameOf = ({ tooth, flank }) => t.toothFlank(fmt.value.count(tooth), t[flank]);

/**
 * The same section of all flanks: at the crosshair, else in the middle.
 * @param {{ kind: "profile" | "helix", flanks: readonly ToothFlank[], picked: ToothFlank, file: string }} props
 */
function Sections({ kind, flanks, picked, file }) {
  const axes = mapAxes(AXES);
  const [along, across] = kind === "profile" ? [axes.u, axes.v] : [axes.v, axes.u];
  const domain = commonRange(flanks, kind === "profile" ? "u" : "v");
  const [low, high] = commonRange(flanks, kind === "profile" ? "v" : "u");
  const given = (query.value.get("at") ?? "").split(",").map(Number)[kind === "profile" ? 1 : 0];
  const at = given !== undefined && given >= low && given <= high ? given : (low + high) / 2;
  const sections = useMemo(
    () => flanks.map((of) => ({ of, points: sectionOf(of.surface, kind, at) })),
    [flanks, kind, at],
  );
  const rows = sections.flatMap(({ of, points }) =>
    points.flatMap(({ x, y }) => (Number.isFinite(y) ? [{ key: `${of.key} ${x}`, of, x, y }] : [])),
  );
  const most = niceAbove(rows.reduce((size, { y }) => Math.max(size, Math.abs(y)), 0)) || 1;
  const place = `${across.label} ${fmt.value.mm(at)} mm`;
  return h(Chart, {
    name: kind === "profile" ? t.allProfiles : t.allHelices,
    summary: t.sectionsAt(place, nameOf(picked)),
    height: 260,
    x: { ...along, domain },
    y: { label: t.deviation, unit: "µm", domain: [-most, most] },
    data: {
      rows,
      rowKey: ({ key }) => key,
      csvName: `${file}-${kind}`,
      columns: [
        { key: "tooth", header: t.toothColumn, rowHeader: true, cell: ({ of }) => nameOf(of), csv: ({ of }) => of.key },
        {
          key: "x",
          header: along.label,
          unit: along.unit,
          numeric: true,
          cell: ({ x }) => html`<span translate="no">${fmt.value.mm(x)}</span>`,
          csv: ({ x }) => x,
        },
        {
          key: "y",
          header: t.deviation,
          unit: "µm",
          numeric: true,
          cell: ({ y }) => html`<span translate="no">${fmt.value.onScale(y, most, "µm")}</span>`,
          csv: ({ y }) => y,
        },
      ],
    },
    children: (plot) => html`${h(Rule, { plot, y: 0, kind: "zero" })}
      ${sections.map(({ of, points }) => of !== picked && h(Line, { key: of.key, plot, points, dash: dashOf(of.flank), thin: true }))}
      ${sections.map(({ of, points }) => of === picked && h(Line, { key: of.key, plot, points, dash: dashOf(of.flank), series: "vermilion" }))}`,
  });
}

/** @param {{ flanks: readonly ToothFlank[], file: string, height: (z: number | undefined) => string }} props */
function TeethTable({ flanks, file, height }) {
  const rows = flanks.map((of) => ({ of, ...inFigures(of) }));
  /** @typedef {(typeof rows)[number]} Row */
  /** @param {"least" | "greatest" | "mean" | "rms"} key @param {string} header @returns {import("../components/table.js").Column<Row>} */
  const um = (key, header) => ({
    key,
    header,
    unit: "µm",
    numeric: true,
    cell: (row) => html`<span translate="no">${height(row[key])}</span>`,
    csv: (row) => row[key],
  });
  return table({
    caption: t.teeth,
    hideCaption: true,
    csvName: file,
    stacked: true,
    rows,
    rowKey: ({ of }) => of.key,
    columns: [
      { key: "name", header: t.toothColumn, rowHeader: true, cell: ({ of }) => nameOf(of), csv: ({ of }) => of.tooth },
      { key: "flank", header: t.flankColumn, csv: ({ of }) => t[of.flank] },
      {
        key: "count",
        header: t.points,
        numeric: true,
        cell: ({ count }) => html`<span translate="no">${fmt.value.count(count)}</span>`,
        csv: ({ count }) => count,
      },
      um("least", t.least),
      um("greatest", t.greatest),
      um("mean", t.mean),
      um("rms", t.rmsShort),
    ],
  });
}
