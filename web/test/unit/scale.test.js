import assert from "node:assert/strict";
import { test } from "node:test";
import { scaleOf, ticksOf } from "../../app/charts/scale.js";
import { formats } from "../../app/lib/format.js";

const en = formats("en");
const de = formats("de");
/** @param {import("../../app/charts/scale.js").AxisSpec} axis @param {typeof en} [f] */
const labels = (axis, f = en) => {
  const ticks = ticksOf(scaleOf(axis, [0, 400]), axis, f);
  return ticks.flatMap(({ label }) => (label === null ? [] : [label]));
};

test("linear ticks have the decimals of their step", () => {
  assert.deepEqual(labels({ label: "", domain: [-1, 1], ticks: 4 }), ["−1.0", "−0.5", "0.0", "0.5", "1.0"]);
  assert.deepEqual(labels({ label: "", domain: [0, 0.02], ticks: 4 }, de), [
    "0,000",
    "0,005",
    "0,010",
    "0,015",
    "0,020",
  ]);
  assert.deepEqual(labels({ label: "", domain: [0, 2e7], ticks: 2 }), ["0", "1.00·10⁷", "2.00·10⁷"]);
});

test("logarithmic ticks are powers of ten, and more of them within few decades", () => {
  assert.deepEqual(labels({ label: "", scale: "log", domain: [1e-9, 1e-4], ticks: 6 }), [
    "10⁻⁹",
    "10⁻⁸",
    "10⁻⁷",
    "10⁻⁶",
    "10⁻⁵",
    "10⁻⁴",
  ]);
  assert.deepEqual(labels({ label: "", scale: "log", domain: [1, 100] }), ["1", "2", "5", "10", "20", "50", "100"]);
  assert.deepEqual(labels({ label: "", scale: "log", domain: [0.1, 0.6] }, de), ["0,1", "0,2", "0,3", "0,5"]);
  const many = ticksOf(
    scaleOf({ label: "", scale: "log", domain: [1e-18, 1e3] }, [0, 400]),
    { label: "", scale: "log", domain: [1e-18, 1e3], ticks: 6 },
    en,
  );
  assert.ok(many.filter(({ label }) => label !== null).length <= 7 && many.length <= 22);
});

test("a domain of one value has a width, and scales go where they should", () => {
  for (const domain of /** @type {[number, number][]} */ ([
    [0, 0],
    [3, 3],
  ])) {
    const scale = scaleOf({ label: "", domain }, [0, 400]);
    assert.equal(scale(domain[0]), 200);
  }
  const log = scaleOf({ label: "", scale: "log", domain: [5, 5] }, [0, 400]);
  assert.ok(Math.abs(log(5) - 200) < 1e-9);
  assert.equal(scaleOf({ label: "", domain: [0, 10] }, [400, 0])(10), 0);
});

test("an axis within a part of a decade is labelled all the same", () => {
  const axis = /** @type {const} */ ({ label: "x", scale: "log", domain: [6.6, 9.4] });
  const labels = ticksOf(scaleOf(axis, [0, 100]), axis, formats("en")).flatMap(({ label }) => label ?? []);
  assert.ok(labels.length >= 2, labels.join(" "));
  assert.ok(labels.every((label) => Number(label) >= 6.6 && Number(label) <= 9.4));
});
