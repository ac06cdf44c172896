// The contents of a chart, read back into numbers by the labels of its axes, as a reader would.

import assert from "node:assert/strict";

/** @typedef {{ x: number, y: number }} Place in pixels of the plot */
/** @typedef {{ label: string, at: number }} Tick */
/** @typedef {{ x: Tick[], y: Tick[], lines: Place[][], dots: Record<string, Place[]>, rules: Partial<Place>[], span: [number, number] | undefined }} Drawn
 *   `dots`: by the name of their series; `rules`: across the plot at x, or at y */

/** The tolerance of a pixel, by which numbers of a path are rounded. */
export const PIXEL = 1.01;

/** @param {import("playwright-core").Locator} figure @returns {Promise<Drawn>} */
export function drawnIn(figure) {
  return figure.locator("svg.chart").evaluate((svg) => {
    const numbers = (/** @type {string | null} */ text) =>
      [...(text ?? "").matchAll(/-?\d+(\.\d+)?(e-?\d+)?/g)].map(([one]) => Number(one));
    const all = (/** @type {string} */ selector) => [...svg.querySelectorAll(selector)];
    const number = (/** @type {Element} */ one, /** @type {string} */ name) => Number(one.getAttribute(name));
    const ticks = (/** @type {string} */ anchor, /** @type {"x" | "y"} */ axis) =>
      all(`.chart-axes g > text[text-anchor=${anchor}]`).map((one) => ({
        label: one.textContent ?? "",
        at: number(one, axis),
      }));
    const place = (/** @type {number[]} */ [x = Number.NaN, y = Number.NaN]) => ({ x, y });
    /** @type {Record<string, Place[]>} */
    const dots = {};
    for (const group of all(".mark-dots")) {
      const series = /series-(\w+)/.exec(group.getAttribute("class") ?? "")?.[1] ?? "";
      const places = [...group.children].map((one) => place(numbers(one.getAttribute("transform"))));
      dots[series] = [...(dots[series] ?? []), ...places];
    }
    const lines = all("path.mark-line").map((one) =>
      (one.getAttribute("d") ?? "")
        .split(/[ML]/)
        .filter(Boolean)
        .map((part) => place(numbers(part))),
    );
    const rules = all(".mark-rule path").map((one) => {
      const { x, y } = place(numbers(one.getAttribute("d")));
      return /H/.test(one.getAttribute("d") ?? "") ? { y } : { x };
    });
    const [rect] = all(".mark-span rect");
    const left = rect && number(rect, "x");
    return {
      x: ticks("middle", "x"),
      y: ticks("end", "y"),
      lines,
      dots,
      rules,
      span: left === undefined ? undefined : [left, left + number(/** @type {Element} */ (rect), "width")],
    };
  });
}

/** Reads `2·10⁻³` and `0.5` as numbers. @param {string} label */
function numberOf(label) {
  const plain = label.replace("−", "-");
  const power = /^(?:([\d.]+)·)?10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)$/.exec(plain);
  if (!power) return Number(plain);
  const digits = [...(power[2] ?? "")].map((one) => (one === "⁻" ? "-" : "⁰¹²³⁴⁵⁶⁷⁸⁹".indexOf(one))).join("");
  return Number(power[1] ?? 1) * 10 ** Number(digits);
}

/**
 * Returns the place of a value on an axis, by two of its labels; all others have to agree.
 * @param {readonly Tick[]} ticks @param {"linear" | "log"} kind @returns {(value: number) => number}
 */
export function axisOf(ticks, kind) {
  const along = kind === "log" ? Math.log : (/** @type {number} */ value) => value;
  const named = ticks.map(({ label, at }) => ({ value: along(numberOf(label)), at }));
  const [first, last] = [named[0], named.at(-1)];
  assert.ok(first && last && first !== last, "an axis has two labels at least");
  const at = (/** @type {number} */ value) =>
    first.at + ((along(value) - first.value) * (last.at - first.at)) / (last.value - first.value);
  for (const { label, at: there } of ticks)
    assert.ok(Math.abs(at(numberOf(label)) - there) < PIXEL, `${label} of a ${kind} axis at ${there}`);
  return at;
}

/** @param {number | undefined} drawn @param {number} expected @param {string} what */
export function near(drawn, expected, what) {
  assert.ok(drawn !== undefined && Math.abs(drawn - expected) < PIXEL, `${what}: at ${drawn}, not ${expected}`);
}

/** Returns the height of a line at x. @param {readonly Place[]} line @param {number} x */
export function heightAt(line, x) {
  const next = Math.max(
    1,
    line.findIndex((one) => one.x >= x),
  );
  const [a, b] = [line[next - 1], line[next]];
  assert.ok(a && b, `the line does not reach ${x}`);
  return a.y + ((b.y - a.y) * (x - a.x)) / (b.x - a.x);
}
