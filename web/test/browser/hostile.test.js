// Names, notes and reasons are text: on every page, on paper and in files.

import assert from "node:assert/strict";
import { execFile } from "node:child_process";
import { readFile } from "node:fs/promises";
import path from "node:path";
import { promisify } from "node:util";
import { browserTest, example } from "./harness.js";

const run = promisify(execFile);
const NAME = "<img src=x onerror=alert(1)>";
const NOTE = "</script><script>alert(2)</script>";
const REASON = '"><svg onload=alert(3)>';

browserTest("what people write is text everywhere", {}, async (world) => {
  const { page, open, job, call, server } = world;
  page.on("dialog", () => assert.fail("a script ran"));
  const { id } = await job({ name: NAME, machine: NOTE, tags: { "<b>": NOTE } });
  const at = `/v1/jobs/${id}/iterations`;
  const flank = { ...JSON.parse(await example("flank_z52.json")), note: NOTE, operator: NAME, instrument: "=1+1" };
  await call("POST", at, flank);
  await call("PATCH", `${at}/1`, { decision: "remachine", reason: REASON });
  await call("POST", `${at}/1/fits`, { ...JSON.parse(await example("requests/refit.json")), reason: REASON });
  await call("POST", `${at}/1/evaluations`, await example("requests/gear_evaluate.json"));
  await call("POST", `${at}/1/correction`, await example("requests/iteration_correction.json"));
  const first = `/jobs/${id}/iterations/1`;
  /** @type {[string, readonly string[]][]} */
  const places = [
    ["/jobs", [NAME, NOTE]],
    [`/jobs/${id}`, [NAME, NOTE]],
    [`/jobs/${id}/measure`, [NAME]],
    [first, [NAME, NOTE, REASON, "=1+1"]],
    [`${first}/lambda`, [NAME, REASON]],
    [`${first}/statistics`, [NAME]],
    [`${first}/evaluation`, [NAME]],
    [`${first}/correction`, [NAME]],
    [`/jobs/${id}/trace`, [NAME, REASON]],
    [`/jobs/${id}/report`, [NAME, NOTE, REASON]],
  ];
  for (const [place, texts] of places) {
    await open(place);
    const said = (await page.locator("main").textContent()) ?? "";
    for (const text of texts) assert.ok(said.includes(text), `${place}: ${text}`);
    assert.equal(await page.locator("img, main script, svg[onload]").count(), 0, place);
  }
  const pdf = path.join(server.folder, "hostile.pdf");
  await page.pdf({ path: pdf, preferCSSPageSize: true });
  const { stdout } = await run("pdftotext", ["-layout", pdf, "-"], { maxBuffer: 1 << 26 });
  assert.ok(stdout.replaceAll(/\s+/gu, " ").includes(NAME));

  await open(`${first}/lambda`);
  const waiting = page.waitForEvent("download");
  const fits = page.locator(".panel", { has: page.getByRole("heading", { name: "Fits of this iteration" }) });
  await fits.getByRole("button", { name: "CSV" }).click();
  const file = await readFile(await (await waiting).path(), "utf8");
  assert.ok(file.includes(`"${REASON.replaceAll('"', '""')}"`), file);
});
