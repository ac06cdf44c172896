// The list of jobs: searched, filtered, sorted, counted.

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { browserTest, example } from "./harness.js";

browserTest("an empty list says what to do next", { alone: true }, async ({ page, open }) => {
  await open("/");
  assert.equal(new URL(page.url()).pathname, "/jobs");
  await page.getByText("Jobs are listed here").waitFor();
  // one action, and two links
  assert.deepEqual(await page.locator("main .button").allTextContents(), ["New job", "API documentation"]);
  await page.locator("main .button.primary", { hasText: "New job" }).waitFor();
  assert.equal(await page.title(), "Jobs – flankfit");
});

browserTest("names are text, in the page and in the file", { alone: true }, async ({ page, open, job }) => {
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
  assert.equal(
    head,
    "Job,Part number,Serial number,Machine,Status,Iterations,Flank,f Hα [µm],f Hβ [µm],C α [µm],C β [µm],S [µm],Within limits,Class,RMS,Condition,Gear,Tags,Last measured,Created,Last change",
  );
  assert.ok(row?.startsWith(`"${name.replaceAll('"', '""')}",97340,0017,'=cmd(),new,0,,,`), row);
});

browserTest(
  "the list shows the result of the last iteration",
  { alone: true },
  async ({ page, open, job, iteration, call }) => {
    const { id } = await job({ name: "measured" });
    await iteration(id);
    await call("PATCH", `/v1/jobs/${id}/iterations/1`, { decision: "remachine", reason: "slope" });
    await iteration(id, "flank_z52_remachined.json");
    const { id: decided } = await job({ name: "decided", machine: "form grinder 2" });
    await iteration(decided);
    await call("PATCH", `/v1/jobs/${decided}/iterations/1`, { decision: "accepted", reason: "good" });
    await job({ name: "waits" });
    await open("/jobs");
    const { items } = await call("GET", "/v1/jobs");
    for (const item of items) {
      const row = page.getByRole("row").filter({ has: page.getByRole("link", { name: item.name }) });
      const cells = await row.locator(".cell").allTextContents();
      const status = { new: "new", open: "open", accepted: "accepted" }[/** @type {"new"} */ (item.status)];
      assert.equal(cells[4]?.trim(), status);
      assert.equal(cells[5], String(item.iteration_count));
      assert.equal(cells[8], item.rms === undefined ? "–" : String(Number(item.rms.toPrecision(3))));
    }
    const counts = page.getByRole("navigation", { name: "Jobs by status" });
    for (const [name, count] of [
      ["All", 3],
      ["new", 1],
      ["open", 1],
      ["machine again", 0],
      ["accepted", 1],
    ])
      await counts.getByRole("link", { name: `${name} ${count}` }).waitFor();
    await counts.getByRole("link", { name: "accepted 1" }).click();
    await page.waitForURL("**/jobs?status=accepted");
    await page.getByRole("link", { name: "measured" }).waitFor({ state: "detached" });
    assert.equal(await page.locator("tbody tr").count(), 1);
    await page.goBack();
    await page.getByRole("link", { name: "measured" }).waitFor();
    await page.getByLabel("Machine").selectOption("form grinder 2");
    await page.waitForURL(/machine=form\+grinder\+2/);
    await page.getByRole("link", { name: "measured" }).waitFor({ state: "detached" });
    assert.deepEqual(await page.getByLabel("Machine").locator("option").allTextContents(), [
      "All machines",
      "form grinder 3 (2)",
      "form grinder 2 (1)",
    ]);
  },
);

browserTest(
  "a search follows what is typed, and says what to do where it finds nothing",
  { alone: true },
  async (world) => {
    const { page, open, loaded, job } = world;
    await job({ name: "Sun gear", part_number: "4711", tags: { cell: "B" } });
    await job({ name: "Planet gear" });
    await open("/jobs");
    await page.keyboard.press("/");
    await page.keyboard.type("SUN");
    await page.getByRole("link", { name: "Planet gear" }).waitFor({ state: "detached" });
    await page.getByRole("link", { name: "Sun gear" }).waitFor();
    assert.equal(await page.evaluate(() => document.activeElement?.getAttribute("type")), "search");
    await page.waitForURL("**/jobs?q=SUN");
    await page.reload();
    await loaded();
    assert.equal(await page.getByLabel("Search").inputValue(), "SUN");
    assert.equal(await page.locator("tbody tr").count(), 1);
    await page.getByLabel("Search").fill("no such thing");
    await page.getByText("No matching jobs.").waitFor();
    await page.getByRole("link", { name: "Show all jobs" }).click();
    await page.getByRole("link", { name: "Planet gear" }).waitFor();
    // the list is there before the field follows the address
    await loaded();
    assert.equal(await page.getByLabel("Search").inputValue(), "");
    await page.getByText("More filters").click();
    await page.getByLabel("Part number").fill("4711");
    await page.getByLabel("Tag").fill("cell:B");
    const today = new Date().toLocaleDateString("sv", { timeZone: "Europe/Berlin" });
    await page.getByLabel("Changed from").fill(today);
    await page.getByLabel("Changed until").fill("2020-01-01");
    await page.getByText("This date is before the first.").waitFor();
    await page.getByRole("button", { name: "Apply" }).click();
    assert.ok(!page.url().includes("part="), "no invalid filter is sent");
    await page.getByLabel("Changed until").fill(today);
    await page.getByRole("button", { name: "Apply" }).click();
    await page.waitForURL(/part=4711&tag=cell%3AB/);
    await page.getByRole("link", { name: "Planet gear" }).waitFor({ state: "detached" });
    await page.getByRole("link", { name: "Sun gear" }).waitFor();
    await page.getByRole("button", { name: "Clear all filters" }).click();
    await page.getByRole("link", { name: "Planet gear" }).waitFor();
    await page.getByLabel("Sort by").selectOption("name");
    await page.waitForURL(/sort=name/);
    await loaded();
    assert.deepEqual(await page.locator("tbody th a").allTextContents(), ["Planet gear", "Sun gear"]);
    await page.getByRole("columnheader", { name: "Last change" }).getByRole("button").click();
    await loaded();
    assert.deepEqual(await page.locator("tbody th a").allTextContents(), ["Planet gear", "Sun gear"]);
  },
);

browserTest(
  "an error of a filter is shown at its field",
  { statuses: [422], alone: true },
  async ({ page, open, job }) => {
    await job();
    await open("/jobs?status=nonsense");
    await page.getByRole("heading", { name: "Invalid request" }).waitFor();
    await page.getByRole("navigation", { name: "Jobs by status" }).getByRole("link", { name: "All 1" }).click();
    await page.getByRole("link", { name: "Pump gear" }).waitFor();
  },
);

browserTest("a path that names nothing has a way back", { statuses: [404] }, async ({ page, server }) => {
  const response = await page.goto(`${server.url}/nothing`);
  assert.equal(response?.status(), 404);
  await page.getByRole("link", { name: "Jobs" }).first().waitFor();
});

browserTest("the list is narrowed down to a class", { statuses: [422], alone: true }, async (world) => {
  const { page, open, loaded, job, iteration, call } = world;
  const { id } = await job({ name: "evaluated" });
  await iteration(id);
  await call("POST", `/v1/jobs/${id}/iterations/1/evaluations`, await example("requests/gear_evaluate.json"));
  await job({ name: "without a class" });
  const { class: found } = (await call("GET", "/v1/jobs?q=evaluated")).items[0];
  assert.ok(found >= 1 && found <= 11, `${found}`);
  const narrow = async (/** @type {string} */ to) => {
    await page.getByLabel("Class", { exact: true }).fill(to);
    await page.getByRole("button", { name: "Apply" }).click();
    await page.waitForURL(`**/jobs?class=${to}`);
    await loaded();
  };
  await open("/jobs");
  await page.getByText("More filters").click();
  await narrow(`${found}`);
  await page.getByRole("link", { name: "without a class" }).waitFor({ state: "detached" });
  await page.getByRole("link", { name: "evaluated" }).waitFor();
  await narrow(`${found === 11 ? 1 : found + 1}`);
  await page.getByRole("link", { name: "evaluated" }).waitFor({ state: "detached" });
  // an invalid class is reported at the field
  await narrow("12");
  await page.locator('[aria-invalid="true"]').waitFor();
  assert.equal(await page.getByLabel("Class", { exact: true }).getAttribute("aria-invalid"), "true");
});

browserTest(
  "a compact list has one line a job, and stays compact",
  { alone: true },
  async ({ page, open, loaded, job }) => {
    const long = "long name ".repeat(16).trim();
    await job({ name: long, tags: { cell: "B" } });
    await open("/jobs");
    const link = page.getByRole("link", { name: long });
    const lines = () => link.evaluate((one) => one.getBoundingClientRect().height / 20.3);
    assert.ok((await lines()) < 2.2, "two lines at most");
    await page.getByRole("button", { name: "Compact" }).click();
    await page.locator("tbody .tags").waitFor({ state: "detached" });
    const height = () => page.locator("tbody tr").evaluate((row) => row.getBoundingClientRect().height);
    assert.ok((await height()) <= 46, `${await height()} px`);
    assert.equal(await link.getAttribute("title"), long);
    await page.reload();
    await loaded();
    assert.ok((await height()) <= 46, `${await height()} px`);
  },
);

for (const density of ["comfortable", "compact"]) {
  browserTest(`columns are chosen and remembered, ${density}`, { alone: true }, async (world) => {
    const { page, open, loaded, job, iteration } = world;
    const { id } = await job();
    await iteration(id);
    await open("/jobs");
    if (density === "compact") await page.getByRole("button", { name: "Compact" }).click();
    const heads = async () => {
      const all = await page.locator("thead th").allTextContents();
      return all.map((one) => one.trim());
    };
    const every = await heads();
    const names = [
      "Part number",
      "Serial number",
      "Machine",
      "Status",
      "Iterations",
      "Flank",
      "Class",
      "RMS",
      "Condition",
    ];
    assert.deepEqual(every, ["Job", ...names, "Last change"]);
    const menu = page.locator(".job-counts .menu");
    await menu.getByText("Columns").click();
    await menu.getByLabel("Last change").waitFor();
    assert.deepEqual(await menu.locator("label").allTextContents(), [...names, "Last change"]);
    const away = ["Serial number", "Flank", "RMS", "Condition"];
    for (const name of away) await menu.getByLabel(name).uncheck();
    await page.locator("thead", { hasText: "Condition" }).waitFor({ state: "detached" });
    const left = every.filter((name) => !away.includes(name));
    assert.deepEqual(await heads(), left);
    assert.equal(await page.getByText("RMS, in the unit of the heights of each job").count(), 0);
    assert.equal(await page.locator(".list-hint").count(), 0);
    await page.keyboard.press("Escape");
    await menu.getByLabel("RMS").waitFor({ state: "hidden" });
    await page.reload();
    await loaded();
    assert.deepEqual(await heads(), left, "after a reload");
    const waiting = page.waitForEvent("download");
    await page.getByRole("button", { name: "CSV" }).click();
    const [head] = (await readFile(await (await waiting).path(), "utf8")).split("\r\n");
    assert.match(head ?? "", /RMS,Condition/, "the file has all");
    await menu.getByText("Columns").click();
    await menu.getByLabel("RMS").check();
    await page.getByText("RMS, in the unit of the heights of each job").waitFor();
    assert.deepEqual(
      await heads(),
      every.filter((name) => name === "RMS" || !away.includes(name)),
    );
  });
}
