import assert from "node:assert/strict";
import { existsSync } from "node:fs";
import { test } from "node:test";
import { href, hrefIf, match, pages } from "../../app/router.js";

test("every page has its module", () => {
  for (const { page } of pages) {
    assert.ok(existsSync(new URL(`../../app/pages/${page}.js`, import.meta.url)), page);
  }
  assert.equal(new Set(pages.map(({ path }) => path)).size, pages.length, "no path twice");
});

test("paths are matched by their segments", () => {
  assert.equal(match("/jobs")?.page.path, "/jobs");
  assert.equal(match("/jobs/"), undefined);
  assert.equal(match("/nothing"), undefined);
  assert.equal(match("/jobs/%E0%A4%A"), undefined, "what is no text names nothing");
  for (const { path } of pages) {
    const params = Object.fromEntries([...path.matchAll(/\{(\w+)\}/g)].map(([, name]) => [name, "a/b ?"]));
    const found = match(new URL(href(path, params), "http://here").pathname);
    assert.deepEqual([found?.page.path, found?.params], [path, params]);
  }
});

test("addresses hold their query, and pages that are not there have none", () => {
  assert.equal(href("/jobs", {}, { cursor: "a b", none: undefined, empty: "" }), "/jobs?cursor=a+b");
  assert.equal(hrefIf("/not/built"), undefined);
});
