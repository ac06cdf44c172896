// The request for a chosen criterion or a value of λ*, k, λ or the rank.

import assert from "node:assert/strict";
import { test } from "node:test";
import { refitOf } from "../../app/regularization/selection.js";

/** @typedef {import("../../app/regularization/selection.js").FitSpec} FitSpec */

/** @param {object | undefined} regularization @param {import("../../app/regularization/selection.js").Selection} selection */
const specOf = (regularization, selection) =>
  refitOf(/** @type {FitSpec} */ (/** @type {unknown} */ ({ regularization })), selection).regularization;

test("a criterion chooses the rank, whatever rank the fit has of its own", () => {
  const svd = { type: "truncated_svd", rank: 8 };
  assert.deepEqual(specOf(svd, { by: "gcv" }), { type: "truncated_svd", parameter: { criterion: "gcv" } });
  assert.deepEqual(specOf(svd, { value: 6.8 }), { type: "truncated_svd", rank: 7 });
  assert.deepEqual(specOf({ type: "truncated_svd", parameter: { criterion: "reml" } }, { value: 7 }), {
    type: "truncated_svd",
    rank: 7,
  });
  assert.deepEqual(specOf(svd, { by: "least_squares" }), { type: "none" });
});

test("the number of other schemes is named as the interface names it, and the rest of them stays", () => {
  const spectral = { type: "spectral", count: 2, lambda_star: { criterion: "gcv" } };
  assert.deepEqual(specOf(spectral, { value: 0.5 }), {
    ...spectral,
    lambda_star: { criterion: "fixed", value: 0.5 },
  });
  assert.deepEqual(specOf({ type: "ridge" }, { by: "hkb" }), { type: "ridge", parameter: { criterion: "hkb" } });
  assert.deepEqual(specOf(undefined, { by: "gcv" }), { type: "spectral", lambda_star: { criterion: "gcv" } });
});
