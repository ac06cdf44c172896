// Slopes, crownings and twist of fits: with errors, intervals, bounds and limits.

import { Strip, StripLegend } from "../charts/strip.js";
import { fmt } from "../i18n/i18n.js";
import { t } from "../i18n/requirements.js";
import { ABSENT } from "../lib/format.js";
import { SURFACE_FIGURES } from "../lib/requirements.js";
import { estimateOf, stripDomain } from "../lib/strip.js";
import { h, html } from "../../vendor/ui.js";
import { WithError } from "./figure.js";
import { GearSymbol } from "./symbol.js";
import { table } from "./table.js";
import { WarningList } from "./warnings.js";
import { Conforms, verdictOf, verdictText, Within } from "./within.js";

/** @typedef {import("../api/client.js").Schema<"FitFigures">} Figures */
/** @typedef {import("../api/client.js").Schema<"FlankFigure">} FlankFigure */
/** @typedef {(typeof SURFACE_FIGURES)[number] & { figure: FlankFigure }} Row */

/** @typedef {(typeof SURFACE_FIGURES)[number]["name"]} Name */
/** @typedef {"left" | "right" | undefined} Side */
/** @typedef {{ number: number, link: import("../../vendor/ui.js").ComponentChildren, flank: Side, figures: Figures | undefined }} IterationFigures */

/** @param {Figures | undefined} figures @param {Name} name */
const figureOf = (figures, name) => figures?.[/** @type {const} */ (`${name}_um`)];

/** Returns a row for each figure of a fit. @param {Figures | undefined} figures @returns {Row[]} */
export function figureRows(figures) {
  return SURFACE_FIGURES.flatMap(({ name, symbol }) => {
    const figure = figureOf(figures, name);
    return figure ? [{ name, symbol, figure }] : [];
  });
}

/** Required limits as text. @param {readonly number[] | undefined} limits */
export function limitText(limits) {
  return limits ? limits.map((end) => fmt.value.input(end).replace("-", "\u2212")).join(" … ") : ABSENT;
}

/** @param {string} text */
const data = (text) => html`<span translate="no">${text}</span>`;

/** The figures of one fit. @param {{ figures: Figures | undefined, level: number }} props `level`: of the intervals */
export function FlankFigures({ figures, level }) {
  const rows = figureRows(figures);
  const percent = fmt.value.input(Number((100 * level).toPrecision(12)));
  const limited = rows.some(({ figure }) => figure.conformity);
  // all figures of a fit have the same reasons
  const why = rows.flatMap(({ figure: { conformity } }) => (conformity ? [verdictOf(conformity).why] : []))[0];
  return html`<section class="panel figures-panel" aria-labelledby="flank-figures">
    <h2 id="flank-figures">${t.figuresOfFit}</h2>
    ${
      rows.length === 0
        ? html`<p class="quiet">${t.noFigures}</p>`
        : html`${table({
            caption: t.figuresOfFit,
            hideCaption: true,
            csvName: "figures",
            stacked: true,
            rows,
            rowKey: ({ name }) => name,
            columns: columns(percent, limited),
            note: html`${t.figuresHint}${limited && ` ${t.conformityHint}`}${why && html` <b>${t.whyDoubtful(why)}</b>`} ${h(StripLegend, { estimates: rows.map(({ figure }) => estimateOf(figure)), limited })}`,
          })}`
    }
    ${(figures?.warnings.length ?? 0) > 0 && h(WarningList, { warnings: figures?.warnings ?? [] })}
  </section>`;
}

/** @param {string} percent @param {boolean} limited @returns {import("./table.js").Column<Row>[]} */
function columns(percent, limited) {
  const interval = t.interval(percent);
  return [
    {
      key: "figure",
      header: t.figure,
      rowHeader: true,
      cell: ({ name, symbol }) => html`${h(GearSymbol, { name: symbol })} <span class="figure-name">${t[name]}</span>`,
      csv: ({ symbol }) => symbol.replace("_", " "),
    },
    {
      key: "value",
      header: t.value,
      unit: "µm",
      numeric: true,
      cell: ({ figure }) =>
        html`${h(WithError, { value: figure.value, error: figure.std_error })} ${!figure.conformity && h(Within, { within: figure.within })}`,
      csv: ({ figure }) => figure.value,
    },
    { key: "error", header: `${t.value}: σ`, unit: "µm", csv: ({ figure }) => figure.std_error },
    {
      key: "interval",
      header: interval,
      unit: "µm",
      numeric: true,
      cell: ({ figure }) => data(fmt.value.interval(figure.interval, figure.std_error)),
      csv: ({ figure }) => figure.interval,
    },
    {
      key: "bias",
      header: t.biasBound,
      unit: "µm",
      numeric: true,
      minor: true,
      cell: ({ figure }) => data(fmt.value.significant(figure.bias_bound, 2)),
      csv: ({ figure }) => figure.bias_bound,
    },
    {
      key: "limits",
      header: t.limitsOf,
      unit: "µm",
      numeric: true,
      cell: limited
        ? ({ figure: { conformity } }) =>
            conformity
              ? html`${data(limitText(conformity.limits_um))}<span class="conformity">${h(Conforms, { conformity, brief: true })}</span>`
              : ABSENT
        : undefined,
      csv: ({ figure }) => figure.conformity?.limits_um,
    },
    {
      key: "strip",
      header: t.drawn,
      cell: ({ figure }) =>
        h(Strip, { estimates: [estimateOf(figure)], limits: figure.conformity?.limits_um, unit: "µm" }),
    },
    {
      key: "conformity",
      header: t.conformity,
      csv: ({ figure: { conformity } }) => verdictText(conformity),
    },
  ];
}

/**
 * The figures of several iterations below each other, from their chosen fits. The limits are those
 * applied to the last iteration that has some, by flank if they differ; other required limits
 * follow below.
 * @param {{ rows: readonly IterationFigures[], required: (name: Name, flank: Side) => readonly number[] | undefined, csvName: string }} props
 */
export function FiguresOfIterations({ rows, required, csvName }) {
  const listed = SURFACE_FIGURES.filter(({ name }) => rows.some(({ figures }) => figureOf(figures, name)));
  /** @param {Name} name @param {Side} flank @returns {readonly number[]} */
  const limitsOf = (name, flank) => {
    const of = rows.filter((row) => row.flank === flank).map(({ figures }) => figureOf(figures, name)?.conformity);
    return of.findLast((conformity) => conformity)?.limits_um ?? [];
  };
  /** @param {Name} name @param {Side} flank @returns {readonly number[]} */
  const requiredOf = (name, flank) => {
    const limits = limitsOf(name, flank);
    const wanted = limits.length > 0 ? required(name, flank) : undefined;
    return wanted && !sameLimits(wanted, limits) ? wanted : [];
  };
  const drawnIn = (/** @type {Name} */ name) =>
    rows.flatMap(({ figures }) => {
      const figure = figureOf(figures, name);
      return figure ? [estimateOf(figure)] : [];
    });
  if (listed.length === 0) return html`<p class="quiet">${t.noFigures}</p>`;
  const flanks = [...new Set(rows.map(({ flank }) => flank))].filter((flank) =>
    listed.some(({ name }) => limitsOf(name, flank).length > 0),
  );
  const bySide = flanks.some((flank) =>
    listed.some(({ name }) => !sameLimits(limitsOf(name, flank), limitsOf(name, flanks[0]))),
  );
  const limited = flanks.length > 0;
  const differs = flanks.some((flank) => listed.some(({ name }) => requiredOf(name, flank).length > 0));
  /** @typedef {{ head: string, ends: (name: Name) => readonly number[] }} Limits */
  /** @param {string} head @param {(name: Name, flank: Side) => readonly number[]} of @returns {Limits[]} */
  const linesOf = (head, of) =>
    (bySide ? flanks : flanks.slice(0, 1)).map((flank) => ({
      head: bySide && flank ? `${head}, ${t[`of_${flank}`]}` : head,
      ends: (name) => of(name, flank),
    }));
  /** @type {(IterationFigures | Limits)[]} */
  const lines = [
    ...rows,
    ...linesOf(differs ? t.limitsDecided : t.limitsOf, limitsOf),
    ...(differs ? linesOf(t.limitsRequired, requiredOf) : []),
  ];
  return html`${table({
    caption: t.figuresOfFit,
    hideCaption: true,
    csvName,
    stacked: true,
    rows: lines,
    rowKey: (line) => ("head" in line ? line.head : line.number),
    rowClass: (line) => ("head" in line ? "summary" : ""),
    note: html`${[t.figuresHint, ...(limited ? [t.conformityHint] : []), ...(differs ? [t.limitsShare] : [])].join(" ")}
      ${h(StripLegend, { estimates: listed.flatMap(({ name }) => drawnIn(name)), limited, oneScale: true })}`,
    columns: [
      {
        key: "iteration",
        header: t.iteration,
        rowHeader: true,
        cell: (line) => ("head" in line ? line.head : line.link),
        csv: (line) => ("head" in line ? line.head : line.number),
      },
      ...listed.map(({ name, symbol }) => {
        const domain = stripDomain(
          drawnIn(name),
          rows.map(({ figures }) => figureOf(figures, name)?.conformity?.limits_um),
        );
        /** @type {import("./table.js").Column<IterationFigures | Limits>} */
        const column = {
          key: name,
          header: `${symbol.replace("_", " ")} ${t[name]}`,
          head: html`${h(GearSymbol, { name: symbol })} <span class="visually-hidden">${t[name]}</span>`,
          unit: "µm",
          numeric: true,
          cell: (line) => {
            if ("head" in line) {
              const limits = line.ends(name);
              return data(limits.length > 0 ? limitText(limits) : ABSENT);
            }
            const figure = figureOf(line.figures, name);
            if (!figure) return ABSENT;
            return html`${h(WithError, { value: figure.value, error: figure.std_error })} ${h(Within, figure)}
              <div>${h(Strip, { estimates: [estimateOf(figure)], limits: figure.conformity?.limits_um, unit: "µm", domain })}</div>`;
          },
          csv: (line) => ("head" in line ? line.ends(name) : figureOf(line.figures, name)?.value),
        };
        return column;
      }),
    ],
  })}`;
}

/** Rounds to the last digit that numbers are sent with. @param {readonly number[]} some @param {readonly number[]} others */
const sameLimits = (some, others) =>
  some.length === others.length &&
  some.every((end, i) => Math.abs(end - (others[i] ?? Number.NaN)) <= 1e-9 * Math.max(1, Math.abs(end)));

/** Figures in short, for an entry of the trace. @param {{ figures: Figures | undefined }} props */
export function FiguresInShort({ figures }) {
  const rows = figureRows(figures);
  if (rows.length === 0) return null;
  return html`<dl class="figures-short" aria-label=${t.figuresOfFit}>
    ${rows.map(
      ({ name, symbol, figure }) => html`<div key=${name}>
        <dt>${h(GearSymbol, { name: symbol })}<span class="visually-hidden">${t[name]}</span></dt>
        <dd>${h(WithError, { value: figure.value, error: figure.std_error, unit: "µm" })} ${h(Within, figure)}</dd>
      </div>`,
    )}
  </dl>`;
}
