// Every warning of the program has its German sentence.

import assert from "node:assert/strict";
import { readdir, readFile } from "node:fs/promises";
import { test } from "node:test";
import dependency from "../../app/i18n/de/dependencies.js";
import problems from "../../app/i18n/de/problems.js";
import requirements from "../../app/i18n/de/requirements.js";
import german from "../../app/i18n/de/warnings.js";
import english from "../../app/i18n/en/requirements.js";
import { counted, plain } from "../../app/lib/warnings.js";

const SOURCES = [
  "estimation/src/result/checks.rs",
  "estimation/src/result/warning.rs",
  "formats/src/table/fault.rs",
  "gear/src/evaluation/warning/mod.rs",
  "gear/src/evaluation/warning/samples.rs",
  "gear/src/evaluation/warning/surface.rs",
  "gear/src/flank_grid/warning.rs",
  "gear/src/geometry/warning.rs",
  "gear/src/warning.rs",
];

test("every code of the engine's warnings has a sentence in German", async () => {
  /** @type {string[]} */
  const codes = [];
  for (const source of SOURCES) {
    const text = await readFile(new URL(`../../../engine/${source}`, import.meta.url), "utf8");
    const named = [...text.matchAll(/^ +"([a-z_]+)" => [A-Z]/gm)];
    assert.ok(named.length > 1, source);
    codes.push(...named.map(([, code = ""]) => code));
  }
  assert.ok(codes.length > 90, `${codes.length} codes`);
  assert.deepEqual(
    codes.filter((code) => !german[code]),
    [],
  );
});

test("every reason to doubt a conformity has words", async () => {
  const document = JSON.parse(await readFile(new URL("../../../openapi/flankfit.json", import.meta.url), "utf8"));
  /** @type {string[]} */
  const codes = document.components.schemas.Doubts.items.enum;
  assert.ok(codes.length > 10, `${codes.length} codes`);
  for (const { because } of [english, requirements])
    assert.deepEqual(
      codes.filter((code) => because(code) === code),
      [],
    );
});

const api = new URL("../../../src/api/", import.meta.url);

test("every code of the interface's own warnings has a sentence in German", async () => {
  /** @type {Set<string>} */
  const codes = new Set();
  for (const name of await readdir(api, { recursive: true })) {
    if (!name.endsWith(".rs")) continue;
    const [text = ""] = (await readFile(new URL(name, api), "utf8")).split("#[cfg(test)]");
    const made = /\b(?:WarningBody::new|notice|warn)\(\s*"([a-z_]{3,})"|\bcode: "([a-z_]+)"|vec!\[\("([a-z_]{3,})",/g;
    for (const [, ...found] of text.matchAll(made)) codes.add(found.find(Boolean) ?? "");
  }
  assert.ok(codes.size > 25, `${codes.size} codes`);
  assert.deepEqual(
    [...codes].filter((code) => !german[code]),
    [],
  );
});

test("every problem of the interface has its title in German", async () => {
  const text = await readFile(new URL("problem/code.rs", api), "utf8");
  const codes = new Set([...text.matchAll(/"urn:flankfit:problem:([a-z_]+)"/g)].map(([, code = ""]) => code));
  assert.ok(codes.size > 25, `${codes.size} codes`);
  assert.deepEqual([...codes].sort(), Object.keys(problems).sort());
});

test("a warning of several traces is listed once, with their number", () => {
  const one = { code: "sparse_samples", message: "samples are 0.3 mm apart" };
  const other = { ...one, message: "samples are 0.4 mm apart" };
  assert.deepEqual(
    counted([one, other, one]).map(({ warning, times }) => [warning.message, times]),
    [
      [one.message, 2],
      [other.message, 1],
    ],
  );
});

test("indistinguishable terms are described in German by their data", () => {
  const figures = { rSquared: "0,999996", index: "2279" };
  assert.equal(
    dependency(["u v", "u v²", "u² v", "v", "u", "1"], figures),
    "u v ist über diesen Knoten fast eine Linearkombination von u v², u² v, v und 2 weiteren Termen (R² = 0,999996, " +
      "Konditionsindex 2279). Deren Koeffizienten sind nicht zu unterscheiden.",
  );
  assert.equal(
    dependency(["v", "v²"], { cosine: "-0,98" }),
    "v und v² verlaufen über diesen Knoten fast gleich (Kosinus -0,98). Deren Koeffizienten sind nicht zu unterscheiden.",
  );
  assert.equal(
    dependency(["v", "v²"], { cosine: "-0,98" }, "basis"),
    "v und v² verlaufen in dieser Basis fast gleich (Kosinus -0,98). In der Basis von Legendre entfällt das: Die Fläche " +
      "und Größen aus ihr sind nicht betroffen.",
  );
});

test("a message has no quotes of code and no more digits than a reader needs", () => {
  assert.equal(
    plain("`x` is 0.011; 1.1400000000000001 mm is below 0.123456789 mm"),
    "x is 0.011; 1.14 mm is below 0.123457 mm",
  );
  const kept = "1234567.25 µm of 12345678.123456 at 0.00001234 and 2.5e-12, v0.1.2, 0.00000000000000002";
  assert.equal(plain(kept), kept);
  assert.equal(
    plain("1234567.1000000001 and 0.0000000123456789 and 1.234567891234e-9; 9.9999999999, 10.000000000"),
    "1234567.1 and 0.0000000123457 and 1.234568e-9; 10, 10",
  );
});
