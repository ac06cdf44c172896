import assert from "node:assert/strict";
import { test } from "node:test";
import { ABSENT, formats, parseNumber } from "../../app/lib/format.js";

const en = formats("en");
const de = formats("de");

test("values are written to the second digit of their standard error", () => {
  const unit = "µm/mm";
  assert.equal(en.withError(7.7391, 0.5213, unit), "7.74 ± 0.52\u202fµm/mm");
  assert.equal(de.withError(7.7391, 0.5213, unit), "7,74 ± 0,52\u202fµm/mm");
  assert.equal(en.withError(-0.31, 0.0999), "−0.31 ± 0.10", "0.0999 is 0.10 to two digits");
  assert.equal(en.withError(-0.3149, 0.0941), "−0.315 ± 0.094");
  assert.equal(en.withError(123.4, 12.3), "123 ± 12");
  assert.equal(en.withError(1234.5, 123.4), "1230 ± 120");
  assert.equal(en.withError(0.01, 2.5), "0.0 ± 2.5", "a value far below its error is 0 to its digits");
  assert.equal(en.withError(-0.01, 2.5), "0.0 ± 2.5", "and has no sign");
  assert.equal(en.withError(7.7391e-8, 5.2e-9), "(7.74 ± 0.52)·10⁻⁸");
  assert.equal(de.withError(-2.5e7, 1.25e6, "N"), "(−2,50 ± 0,13)·10⁷\u202fN");
  assert.equal(en.withError(0, 0.5), "0.00 ± 0.50");
  assert.equal(en.withError(3.25, undefined, "µm"), "3.25\u202fµm", "without an error: three digits");
  assert.equal(en.withError(3.25, 0), "3.25");
  assert.equal(en.withError(undefined, 0.5), ABSENT);
  assert.equal(en.withError(Number.NaN, 0.5), ABSENT);
});

test("every kind of number has its digits", () => {
  assert.equal(en.um(-0.04), "0.0");
  assert.equal(en.um(-12.35), "−12.3");
  assert.equal(de.mm(1.23456), "1,235");
  assert.equal(en.three(6.4e-6), "6.40·10⁻⁶");
  assert.equal(de.three(0.00123456), "0,00123");
  assert.equal(en.three(0.0001), "1.00·10⁻⁴");
  assert.equal(en.three(0.0012), "0.00120");
  assert.equal(en.three(999.6), "1000");
  assert.equal(en.three(12345), "1.23·10⁴");
  assert.equal(en.three(0), "0");
  assert.equal(en.condition(1234), "1200");
  assert.equal(en.condition(18.3), "18");
  assert.equal(en.condition(4.4e9), "4.4·10⁹");
  assert.equal(en.count(123456), "123,456");
  assert.equal(de.count(123456), "123.456");
  for (const value of [undefined, null, Number.NaN, Number.POSITIVE_INFINITY]) {
    for (const write of [en.um, en.mm, en.three, en.condition, en.count]) assert.equal(write(value), ABSENT);
  }
});

test("a value next to a scale or an axis has the decimals of its labels", () => {
  assert.equal(en.onScale(0.0034, 0.01, "µm"), "0.003");
  assert.equal(en.onScale(-0.0034, 0.01, "µm"), "−0.003");
  assert.equal(de.onScale(0.234, 0.5, "µm"), "0,23");
  assert.equal(en.onScale(-12.35, 20, "µm"), "−12.3");
  assert.equal(en.onScale(834.56, 1000, "µm"), "834.6");
  assert.equal(en.onScale(0.0123, 0.5, "mm"), "0.012", "1 µm of a length in mm");
  assert.equal(en.onScale(0.00123, 0.005, "mm"), "0.0012");
  assert.equal(en.onScale(1.0012, 6, "caller’s unit"), "1.001", "four digits of the scale");
  assert.equal(en.onScale(81234.5, 1e5, undefined), "81235");
  assert.equal(en.onScale(1.234e-5, 2e-5, "µm"), "1.23·10⁻⁵", "by a power of ten, as the labels are");
  assert.equal(en.onScale(0, 0, "µm"), "0.0", "a scale of no width");
  assert.equal(en.onScale(undefined, 10, "µm"), ABSENT);
});

test("times are of the reader's place, and absent ones are said so", () => {
  assert.match(en.time("2026-11-21T08:30:00Z"), /^21 Nov 2026, \d\d:30$/);
  assert.match(de.time("2026-11-21T08:30:00Z"), /^21\.11\.2026, \d\d:30$/);
  assert.equal(en.time(undefined), ABSENT);
  assert.equal(en.date("no time"), ABSENT);
});

test("fields take point and comma", () => {
  for (const text of ["1.25", "1,25", " 1,25 ", "+1.25", "12.5e-1", "12,5E-1"])
    assert.equal(parseNumber(text), 1.25, text);
  assert.equal(parseNumber("−0,5"), -0.5);
  assert.equal(parseNumber(""), undefined);
  for (const text of ["1.2.3", "1,234,5", "1.234,5", "abc", "1 000", "0x10", "Infinity", "--1"]) {
    assert.ok(Number.isNaN(parseNumber(text)), text);
  }
  assert.equal(de.input(1.25), "1,25");
  assert.equal(de.input(undefined), "");
});

test("intervals are written to the second digit of their error", () => {
  assert.equal(en.interval([0.64076, 0.76727], 0.0323), "0.641 … 0.767");
  assert.equal(de.interval([-0.0486, 0.7235], 0.195, "µm"), "−0,05 … 0,72\u202fµm");
  assert.equal(en.interval([1, 1], undefined), "1.000 … 1.000");
  assert.equal(en.interval(undefined, 0.1), ABSENT);
});

test("deviations have the digits of an error that they go with, else those of their unit", () => {
  assert.equal(en.deviation(7.7412, "µm", 0.517), "7.74");
  assert.equal(de.deviation(-14.861, undefined, 0.03), "−14,861");
  assert.equal(en.deviation(1234.5, "µm", 120), "1230");
  assert.equal(en.deviation(7.7412, "µm"), "7.7");
  assert.equal(en.deviation(0.0774, "mm"), "0.077");
  assert.equal(en.deviation(0.077412, undefined), "0.07741");
  assert.equal(en.deviation(undefined, "µm", 0.5), ABSENT);
});

test("fields begin with all digits, small numbers by a power of ten", () => {
  assert.equal(formats("en").input(0.00000635949), "6.35949e-6");
  assert.equal(formats("de").input(0.00000635949), "6,35949e-6");
  assert.equal(parseNumber("6,35949e-6"), 6.35949e-6);
  assert.equal(formats("de").input(-1.25), "-1,25");
  assert.equal(formats("en").input(0), "0");
});
