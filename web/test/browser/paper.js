// A job with everything that a report has, and the report on paper.

import assert from "node:assert/strict";
import { execFile } from "node:child_process";
import path from "node:path";
import { promisify } from "node:util";
import { example, painted } from "./harness.js";

/** @typedef {import("./harness.js").World} World */

export const run = promisify(execFile);

/**
 * Returns the pages of the print as text: runs of space are one.
 * @param {World} world
 */
export async function printed({ page, server }) {
  const file = path.join(server.folder, "report.pdf");
  await page.pdf({ path: file, preferCSSPageSize: true, printBackground: true });
  const { stdout } = await run("pdftotext", ["-layout", file, "-"], { maxBuffer: 1 << 26 });
  // a form feed ends each page
  const pages = stdout.split("\f");
  assert.equal(pages.pop(), "");
  return { file, pages: pages.map((text) => text.replaceAll(/\s+/gu, " ")) };
}

/** Creates two iterations, a correction between them, decisions. @param {World} world @param {object} [change] of the job */
export async function story({ job, iteration, call }, change) {
  const { id } = await job(change);
  await iteration(id);
  const at = `/v1/jobs/${id}/iterations`;
  const kept = await call("POST", `${at}/1/fits`, JSON.parse(await example("requests/refit.json")));
  await call("PUT", `${at}/1/chosen-fit`, { fit_id: kept.id, reason: "the error budget asks for it" });
  await call("POST", `${at}/1/evaluations`, await example("requests/gear_evaluate.json"));
  await call("POST", `${at}/1/correction`, JSON.parse(await example("requests/iteration_correction.json")));
  await call("PATCH", `${at}/1`, { decision: "remachine", reason: "beyond class 5" });
  await iteration(id, "flank_z52_remachined.json");
  await call("PATCH", `${at}/2`, { decision: "accepted", reason: "within the drawing" });
  return id;
}

/** Fails if the first page is higher or wider than its paper. @param {World} world @param {string} lang */
export async function onPaper({ page }, lang) {
  await page.emulateMedia({ media: "print" });
  // parts drawn for the width of the paper are drawn again, once that is known
  await painted(page);
  await painted(page);
  const [tall, wide] = await page.locator(".report-cover").evaluate((cover) => {
    const right = cover.getBoundingClientRect().right;
    const cells = [...cover.querySelectorAll("td, th")].map((cell) => cell.getBoundingClientRect().right);
    return [cover.scrollHeight - cover.clientHeight, Math.max(...cells) - right];
  });
  assert.ok((tall ?? 1) <= 0, `${tall} px too high in ${lang}`);
  assert.ok((wide ?? 1) < 1, `${wide} px too wide in ${lang}`);
  await page.emulateMedia({ media: null });
}

/** @param {readonly string[]} words @param {string} text */
export function holds(text, words) {
  for (const word of words) assert.ok(text.includes(word.replaceAll(/\s+/gu, " ")), `${word}\nin\n${text}`);
}
