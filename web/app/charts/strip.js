// An estimate in a cell of a table: its error, interval, bias bound, least-squares value and
// limits, along a line. The same row and the name of the picture have the numbers.

import de from "../i18n/de/strip.js";
import en from "../i18n/en/strip.js";
import { fmt, texts } from "../i18n/i18n.js";
import { finite, stripDomain } from "../lib/strip.js";
import { h, html } from "../../vendor/ui.js";
import { Band, Dots, Whiskers } from "./marks.js";
import { scaleOf } from "./scale.js";

/** @typedef {import("../lib/strip.js").Estimate} Estimate */
/** @typedef {import("./marks.js").Series} Series */
/** @typedef {Estimate & { name?: string, series?: Series, sign?: "circle" | "square" | "diamond" }} Drawn */

const t = texts({ en, de });
const MARGIN = 7;
/** The width of a strip, and the height of a lane: alone, shared, and on paper. */
const [WIDTH, ALONE, SHARED] = [168, 20, 14];
const [WIDTH_ON_PAPER, ON_PAPER] = [66, 7];
/** The distance of a mark from the middle of its lane, relative to the lane. */
const [BIAS, SHORT] = [0.34, 0.42];

/**
 * @param {{ estimates: readonly Drawn[], limits?: readonly number[] | null | undefined, unit?: string | undefined,
 *   domain?: readonly [number, number], paper?: boolean }} props each in a lane of its own; `domain`: where several strips
 *   have one scale; `paper`: for the report
 */
export function Strip({ estimates, limits, unit, domain = stripDomain(estimates, [limits]), paper = false }) {
  const drawn = estimates.filter(({ value }) => finite(value));
  if (drawn.length === 0) return null;
  const width = paper ? WIDTH_ON_PAPER : WIDTH;
  const height = (paper ? ON_PAPER : drawn.length > 1 ? SHARED : ALONE) * drawn.length;
  const plot = {
    x: scaleOf({ label: "", domain }, [MARGIN, width - MARGIN]),
    y: scaleOf({ label: "", domain: [drawn.length, 0] }, [height, 0]),
    width,
    height,
  };
  const zero = plot.x(0);
  const [low, high] = (limits ?? []).map((end) => plot.x(end));
  // if colours do not name the estimates, one outside its limits is red
  const [least = Number.NEGATIVE_INFINITY, greatest = Number.POSITIVE_INFINITY] = limits ?? [];
  const out = drawn.length === 1 && drawn.every(({ value }) => finite(value) && (value < least || value > greatest));
  const name = drawn.map((one) => said(one, limits, unit)).join(" ");
  return html`<svg class=${["chart strip", paper && "paper", out && "out"].filter(Boolean).join(" ")} role="img" aria-label=${name} width=${width} height=${height} viewBox=${`0 0 ${width} ${height}`}>
    ${low !== undefined && high !== undefined && html`<g class="strip-limits"><rect x=${low} y="0" width=${Math.max(0, high - low)} height=${height} /><path d=${`M${low} 0V${height}M${high} 0V${height}`} /></g>`}
    ${zero >= MARGIN && zero <= width - MARGIN && html`<path class="strip-zero" d=${`M${zero} 0V${height}`} />`}
    ${drawn.map((one, lane) => h(Lane, { key: lane, plot, one, y: lane + 0.5, small: drawn.length > 1 || paper }))}
  </svg>`;
}

/** @param {{ plot: import("./chart.js").Plot, one: Drawn, y: number, small: boolean }} props */
function Lane({ plot, one, y, small }) {
  const { value, error, interval, bias, leastSquares, series = "blue", sign = "circle" } = one;
  if (!finite(value)) return null;
  const [low, high] = interval ?? [];
  const ends = (/** @type {number} */ by) =>
    [value - by, value + by].map((x) => ({ x, low: y - BIAS, high: y + BIAS }));
  const middle = plot.y(y);
  return html`<g>
    ${finite(bias) && bias > 0 && h(Band, { plot, points: ends(bias), series, hatched: true })}
    ${finite(low) && finite(high) && h(Whiskers, { plot, points: [{ y, low, high }], series })}
    ${finite(error) && error > 0 && html`<path class=${`strip-error series-${series}`} d=${`M${plot.x(value - error)} ${middle}H${plot.x(value + error)}`} />`}
    ${finite(leastSquares) && html`<path class="strip-tick" d=${`M${plot.x(leastSquares)} ${plot.y(y - SHORT)}V${plot.y(y + SHORT)}`} />`}
    ${h(Dots, { plot, points: [{ x: value, y }], series, sign, small })}
  </g>`;
}

/** Describes a strip in words. @param {Drawn} one @param {readonly number[] | null | undefined} limits @param {string | undefined} unit */
function said({ name, value, error, interval, intervalError, bias, leastSquares }, limits, unit) {
  const { value: write } = fmt;
  const behind = unit ? `\u202f${unit}` : "";
  const parts = [
    write.withError(value, error, unit),
    interval && t.intervalFrom(write.interval(interval, intervalError ?? error) + behind),
    finite(bias) && t.biasOf(write.significant(bias, 2) + behind),
    finite(leastSquares) && t.leastSquaresOf(write.deviation(leastSquares, unit, error) + behind),
    limits && t.limitsOf(write.interval(limits, 1) + behind),
  ].filter(Boolean);
  return `${name ? `${name}: ` : ""}${parts.join("; ")}.`;
}

/**
 * The legend of the marks of strips.
 * @param {{ estimates: readonly Drawn[], limited?: boolean, oneScale?: boolean, named?: readonly { name: string, series?: Series, sign?: Drawn["sign"] }[] }} props
 *   of the strips; `named`: estimates distinguished by colour and shape; `oneScale`: for a whole column, not per row
 */
export function StripLegend({ estimates, limited = false, oneScale = false, named }) {
  const some = (/** @type {keyof Estimate} */ key) =>
    estimates.some((one) => one[key] !== undefined && one[key] !== null);
  const sign = { width: 26, height: 14, domain: /** @type {const} */ ([0, 26]) };
  const plot = {
    ...sign,
    x: scaleOf({ label: "", domain: sign.domain }, [0, sign.width]),
    y: scaleOf({ label: "", domain: [1, 0] }, [sign.height, 0]),
  };
  const picture = (/** @type {import("../../vendor/ui.js").ComponentChildren} */ mark) =>
    html`<svg class="chart" width="26" height="14" viewBox="0 0 26 14" aria-hidden="true">${mark}</svg>`;
  const dot = (/** @type {{ series?: Series, sign?: Drawn["sign"] }} */ { series = "blue", sign: of = "circle" }) =>
    picture(h(Dots, { plot, points: [{ x: 13, y: 0.5 }], series, sign: of }));
  const items = [
    ...(named ?? [{ name: t.estimate }]).map((one) => [dot(one), one.name]),
    some("error") && [picture(html`<path class="strip-error series-blue" d="M3 7H23" />`), t.error],
    some("interval") && [picture(h(Whiskers, { plot, points: [{ y: 0.5, low: 2, high: 24 }] })), t.interval],
    some("bias") && [
      picture(h(Band, { plot, points: [2, 24].map((x) => ({ x, low: 0.1, high: 0.9 })), hatched: true })),
      t.bias,
    ],
    some("leastSquares") && [picture(html`<path class="strip-tick" d="M13 1V13" />`), t.leastSquares],
    limited && [
      picture(html`<g class="strip-limits"><rect x="4" width="18" height="14" /><path d="M4 0V14M22 0V14" /></g>`),
      t.limits,
    ],
    [picture(html`<path class="strip-zero" d="M13 0V14" />`), t.zero],
  ].filter((one) => one !== false);
  return html`<span class="strip-legend">
    ${items.map(([mark, name], i) => html`<span key=${i}>${mark}${name}</span>`)}
    <span>${oneScale ? t.columnScale : t.rowScale}</span>
  </span>`;
}
