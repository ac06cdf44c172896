// Terms in mathematical notation, and digests that distinguish contents.

import assert from "node:assert/strict";
import { test } from "node:test";
import { digestOf } from "../../app/lib/digest.js";
import { termSign } from "../../app/lib/terms.js";

test("terms are written by hand", () => {
  assert.equal(termSign("u^2*v"), "u²\u202fv");
  assert.equal(termSign("T1(u)*T2(v)"), "T₁(u)\u202fT₂(v)");
  assert.equal(termSign("u^10"), "u^10");
  assert.equal(termSign(undefined), "");
});

test("a digest is of the content alone, and of all of it", () => {
  assert.equal(digestOf("abc"), digestOf("abc"));
  assert.equal(digestOf("abc"), digestOf(new TextEncoder().encode("abc")));
  const many = new Set(Array.from({ length: 20_000 }, (_, i) => digestOf(`{"z":[${i},${i * 7}]}`)));
  assert.equal(many.size, 20_000);
  assert.notEqual(digestOf("ab"), digestOf("ba"));
  assert.notEqual(digestOf(""), digestOf("\0"));
});
