// The list of jobs.

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { browserTest } from "./harness.js";

browserTest("an empty list says what to do next", {}, async ({ page, open }) => {
  await open("/");
  assert.equal(new URL(page.url()).pathname, "/jobs");
  await page.getByText("There is no job yet").waitFor();
  assert.equal(await page.title(), "Jobs – flankfit");
});

browserTest("names are text, in the page and in the file", {}, async ({ page, open, job }) => {
  const name = '<img src=x onerror=alert(1)>"; =1+1';
  await job({ name, machine: "=cmd()", tags: { "</script>": "<b>x</b>" } });
  page.on("dialog", () => assert.fail("a script ran"));
  await open("/jobs");
  await page.getByText(name, { exact: true }).waitFor();
  assert.equal(await page.locator("main img, main b b, main script").count(), 0);
  const waiting = page.waitForEvent("download");
  await page.getByRole("button", { name: "CSV" }).click();
  const text = await readFile(await (await waiting).path(), "utf8");
  const [head, row] = text.split("\r\n");
  assert.equal(head, "Job,Part number,Serial number,Machine,Gear,Tags,Last change");
  assert.ok(row?.startsWith(`"${name.replaceAll('"', '""')}",97340,0017,'=cmd(),`), row);
});

browserTest("fifty a page, and back by the browser", {}, async ({ page, open, stands, job }) => {
  for (let i = 1; i <= 52; i += 1) await job({ name: `Job ${i}` });
  await open("/jobs");
  const rows = page.locator("tbody tr");
  assert.equal(await rows.count(), 50);
  await page.getByText("Job 52", { exact: true }).waitFor();
  await page.getByRole("link", { name: "Older" }).click();
  await page.getByText("Job 2", { exact: true }).waitFor();
  await stands();
  assert.equal(await rows.count(), 2);
  await page.goBack();
  await page.getByText("Job 52", { exact: true }).waitFor();
  assert.equal(await rows.count(), 50);
  await page.goForward();
  await page.getByText("Job 1", { exact: true }).waitFor();
  await page.reload();
  await page.getByText("Job 1", { exact: true }).waitFor();
});

browserTest("a path that names nothing has a way back", { statuses: [404] }, async ({ page, server }) => {
  // the server answers unknown paths with a problem, not with a page
  const response = await page.goto(`${server.url}/nothing`);
  assert.equal(response?.status(), 404);
  assert.equal(response?.headers()["content-type"], "application/problem+json");
});
