// A value with its error and unit.

import { fmt } from "../i18n/i18n.js";
import { html } from "../../vendor/ui.js";

/** @typedef {import("../../vendor/ui.js").ComponentChildren} Children */

/**
 * A value to the second digit of its standard error; in narrow columns the error is below it.
 * @param {{ value: number | null | undefined, error?: number | null | undefined, unit?: string | undefined }} props
 */
export function WithError({ value, error, unit }) {
  const text = fmt.value.withError(value, error, unit);
  // a unit follows the common power of ten of value and error
  const at = text.indexOf(text.startsWith("(") ? "\u202f" : " ±");
  return html`<span class="figure" translate="no">${at < 0 ? text : html`<span>${text.slice(0, at)}</span><span>${text.slice(at)}</span>`}</span>`;
}

/**
 * Names with their values: short facts of one thing.
 * @param {{ items: readonly { name: Children, value: Children, note?: Children }[], columns?: boolean }} props
 */
export function Facts({ items, columns = false }) {
  return html`<dl class=${columns ? "facts columns" : "facts"}>
    ${items.map(
      ({ name, value, note }, i) => html`<div key=${typeof name === "string" ? name : i}>
        <dt>${name}</dt>
        <dd>${value}${note && html` <span class="quiet">${note}</span>`}</dd>
      </div>`,
    )}
  </dl>`;
}

/** A neutral state. */
const RING = "M8 4.5a3.5 3.5 0 1 0 0 7a3.5 3.5 0 1 0 0 -7";

/**
 * A decision or a state with its word, sign and colour.
 * @param {{ kind: "good" | "warn" | "bad" | "news" | "plain", children: Children }} props
 */
export function Badge({ kind, children }) {
  const sign = {
    good: "M3 8.5l3.5 3.5L13 5",
    warn: "M8 3v6M8 12v1",
    bad: "M4 4l8 8M12 4l-8 8",
    news: RING,
    plain: RING,
  }[kind];
  return html`<span class=${`badge ${kind}`}>
    <svg viewBox="0 0 16 16" width="12" height="12" aria-hidden="true"><path d=${sign} /></svg>${children}
  </span>`;
}
