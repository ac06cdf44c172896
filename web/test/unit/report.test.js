// The contents of a report by its address, and its page boxes.

import assert from "node:assert/strict";
import { test } from "node:test";
import { endsOf, isPair } from "../../app/report/pairs.js";
import { cssString, pageRules } from "../../app/report/page_boxes.js";
import { iterationsOf, PARTS, partsOf, written } from "../../app/report/parts.js";

test("without a choice a report has the first and the last iteration, and all parts", () => {
  assert.deepEqual(iterationsOf(null, [1, 2, 3]), [1, 3]);
  assert.deepEqual(iterationsOf(null, [1]), [1]);
  assert.deepEqual(iterationsOf(null, []), []);
  assert.deepEqual(partsOf(null), PARTS);
});

test("what the address names is shown in its order, and what is not there is left out", () => {
  assert.deepEqual(iterationsOf("3,2,9,x", [1, 2, 3]), [2, 3]);
  assert.deepEqual(iterationsOf("9", [1, 2, 3]), [1, 3]);
  assert.deepEqual(partsOf("trace,summary,nothing"), ["summary", "trace"]);
  assert.deepEqual(partsOf("nothing"), PARTS);
  assert.equal(written([1, 3], [1, 3]), undefined);
  assert.equal(written([1, 2, 3], [1, 3]), "1,2,3");
});

test("a name cannot leave the string of a page box", () => {
  assert.equal(cssString('a"}\n'), '"a\\22 \\7d \\a "');
  const rules = pageRules({ job: '";} body { display: none } \\', date: "1", page: "p" });
  assert.ok(!rules.includes("body {"), rules);
  assert.equal(rules.match(/\{/g)?.length, 4);
});

test("before and after are of the same flank and tooth", () => {
  const made = (/** @type {number} */ number, /** @type {string} */ flank, tooth = "1") =>
    /** @type {import("../../app/report/data.js").ReportData} */ (
      /** @type {unknown} */ ({ iteration: { number, flank, tooth } })
    );
  const numbers = (/** @type {readonly import("../../app/report/data.js").ReportData[]} */ all) =>
    endsOf(all).map(({ iteration }) => iteration.number);
  const [left, right, again] = [made(1, "left"), made(2, "right"), made(3, "right")];
  assert.deepEqual(numbers([left, right, again]), [2, 3]);
  assert.ok(isPair(endsOf([left, right, again])));
  assert.deepEqual(numbers([left, right]), [1, 2]);
  assert.ok(!isPair(endsOf([left, right])));
  assert.ok(!isPair(endsOf([right, made(3, "right", "2")])));
  assert.ok(!isPair(endsOf([left])));
  assert.deepEqual(numbers([]), []);
});
