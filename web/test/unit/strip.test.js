// The range over which an estimate is drawn.

import assert from "node:assert/strict";
import { test } from "node:test";
import { estimateOf, stripDomain } from "../../app/lib/strip.js";

test("a strip holds all that is known of its estimates, and their limits", () => {
  const one = { value: 20, error: 0.5, interval: [18, 21], bias: 3, leastSquares: 24 };
  assert.deepEqual(stripDomain([one]), [17, 24]);
  assert.deepEqual(stripDomain([one], [[16, 30]]), [16, 30]);
  assert.deepEqual(stripDomain([one, { value: -2 }]), [-2, 24]);
});

test("zero is in it where it is no farther than what is drawn is wide", () => {
  assert.deepEqual(stripDomain([{ value: 3, error: 1.5 }]), [0, 4.5]);
  assert.deepEqual(stripDomain([{ value: -3, error: 1.5 }]), [-4.5, 0]);
  assert.deepEqual(stripDomain([{ value: 30, error: 1.5 }]), [28.5, 31.5]);
});

test("a lone value, and none, have a width too", () => {
  assert.deepEqual(stripDomain([{ value: 4 }]), [2, 6]);
  assert.deepEqual(stripDomain([{ value: 0 }]), [-1, 1]);
  assert.deepEqual(stripDomain([{ value: null, error: Number.NaN }]), [-1, 1]);
});

test("the interface's names are taken over", () => {
  const coefficient = {
    value: 1,
    std_error: 2,
    interval: [0, 3],
    bias_bound: 4,
    least_squares: 5,
    least_squares_std_error: 6,
  };
  assert.deepEqual(estimateOf(coefficient), {
    value: 1,
    error: 2,
    interval: [0, 3],
    intervalError: 6,
    bias: 4,
    leastSquares: 5,
  });
});
