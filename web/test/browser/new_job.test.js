// A new job, with its gear.

import assert from "node:assert/strict";
import { browserTest } from "./harness.js";
import { rexsModel } from "./tester_files.js";

browserTest(
  "a job with a gear, whose derived data are the server's",
  { alone: true },
  async ({ page, open, loaded, call }) => {
    await open("/jobs");
    await page.getByRole("link", { name: "New job" }).first().click();
    await page.getByRole("heading", { name: "New job" }).waitFor();
    await page.getByLabel("Name", { exact: true }).fill("Pump gear");
    await page.getByLabel("Machine").fill("grinder 3");
    await page.getByText("Add tags").click();
    await page.getByLabel("Tags").fill("cell = B\nshift = early");
    await page.getByLabel("Teeth z").fill("52");
    await page.getByLabel("Normal module").fill("1");
    await page.getByLabel("Profile shift").fill("0,011");
    await page.getByLabel("Face width").fill("15");
    const gear = { teeth: 52, normal_module_mm: 1, profile_shift_coefficient: 0.011, face_width_mm: 15 };
    const geometry = await call("POST", "/v1/gears/geometry", { gear });
    const derived = page.getByRole("region", { name: "Derived quantities" });
    await derived.getByText(`${geometry.base_diameter_mm.toFixed(3)} mm`).waitFor();
    await derived.getByText(`${geometry.tip_diameter_mm.toFixed(3)} mm`, { exact: true }).waitFor();
    await page.getByRole("button", { name: "Create the job" }).click();
    await page.getByRole("heading", { name: "Pump gear" }).waitFor();
    await loaded();
    const { items } = await call("GET", "/v1/jobs");
    assert.equal(items.length, 1);
    assert.deepEqual(items[0].gear, gear);
    assert.deepEqual(items[0].tags, { cell: "B", shift: "early" });
    assert.equal(new URL(page.url()).pathname, `/jobs/${items[0].id}`);
    await page.getByText("appear here after the first measurement").waitFor();
  },
);

browserTest("a name, teeth and a module are required, among few fields", {}, async ({ page, open, loaded }) => {
  await open("/jobs/new");
  const fields = page.locator("main :is(input, select, textarea)");
  const shown = await fields.evaluateAll((all) => all.filter((one) => one.checkVisibility()).length);
  assert.ok(shown <= 12, `${shown} fields`);
  assert.ok((await fields.count()) > 40, "the others are folded");
  const derived = page.getByRole("region", { name: "Derived quantities" });
  await page.getByLabel("Teeth z").fill("12");
  await page.getByLabel("Normal module").fill("1.9");
  await derived.locator("dt sub", { hasText: "bt" }).waitFor();
  await loaded();
  const words = (await derived.textContent()) ?? "";
  assert.match(words, /undercut/, "a gear with a warning of many digits");
  assert.doesNotMatch(words, /d_b|p_bt|\d\.\d{7}/);
});

browserTest("an error in folded sections opens them", {}, async ({ page, open }) => {
  await open("/jobs/new");
  await page.getByLabel("Name", { exact: true }).fill("Folded");
  await page.getByLabel("With gear data").uncheck();
  await page.getByText("Enter them now").click();
  await page.getByText("Limits of one flank").click();
  const field = page.getByLabel("Profile slope, Left flank, from");
  await field.fill("many");
  await page.getByText("Limits of one flank").click();
  await page.getByText("Enter them now").click();
  assert.equal(await field.isVisible(), false);
  await page.getByRole("button", { name: "Create the job" }).click();
  await page.locator(":focus", { has: page.locator("xpath=self::input[@aria-invalid='true']") }).waitFor();
  assert.equal(await field.isVisible(), true);
  assert.equal(await field.evaluate((one) => one === document.activeElement), true);
});

browserTest("a plain job needs a name only", { alone: true }, async ({ page, open, call }) => {
  await open("/jobs/new");
  await page.getByLabel("With gear data").uncheck();
  await page.getByRole("button", { name: "Create the job" }).click();
  await page.getByText("Required.").waitFor();
  // the focus goes there with the next frame
  await page.waitForFunction(
    () => document.activeElement?.closest(".field")?.querySelector("label")?.textContent === "Name",
  );
  await page.keyboard.type("A flank");
  await page.keyboard.press("Enter");
  await page.getByRole("heading", { name: "A flank" }).waitFor();
  const { items } = await call("GET", "/v1/jobs");
  assert.deepEqual([items[0].name, items[0].gear], ["A flank", undefined]);
});

browserTest("an error of the server is shown at its field", { statuses: [422] }, async ({ page, open }) => {
  await open("/jobs/new");
  await page.getByLabel("Name", { exact: true }).fill("Too steep");
  await page.getByLabel("Teeth z").fill("20.5");
  await page.getByText("Not a whole number.").waitFor();
  await page.getByLabel("Teeth z").fill("20");
  await page.getByLabel("Normal module").fill("2");
  await page.getByLabel("Helix angle").fill("95");
  await page.getByRole("button", { name: "Create the job" }).click();
  const field = page.getByLabel("Helix angle");
  await page.locator('[aria-invalid="true"]').waitFor();
  assert.equal(await field.getAttribute("aria-invalid"), "true");
  const expected = await field.getAttribute("aria-describedby");
  assert.match((await page.locator(`#${expected?.split(" ")[0]}`).textContent()) ?? "", /89/);
  await page.getByRole("heading", { name: "Invalid request" }).first().waitFor();
});

browserTest(
  "a gear comes from a file that the program reads",
  { alone: true },
  async ({ page, open, call, server }) => {
    const form = new FormData();
    form.append("file", new Blob([rexsModel()]), "gear.rexs");
    const own = await (await fetch(`${server.url}/v1/gears/read`, { method: "POST", body: form })).json();
    const [wheel, pinion] = own.gears;
    await open("/jobs/new");
    await page
      .getByLabel("Gear from a file")
      .setInputFiles({ name: "gear.rexs", mimeType: "application/xml", buffer: Buffer.from(rexsModel()) });
    await page.getByText("The file contains 2 gears.").waitFor();
    assert.ok(pinion.missing.length > 0);
    await page.getByText(`Incomplete in the file: ${pinion.missing.join(", ")}`).waitFor();
    await page.getByRole("button", { name: "Use", exact: true }).click();
    assert.equal(await page.getByLabel("Teeth z").inputValue(), String(wheel.gear.teeth));
    assert.equal(await page.getByLabel("Name", { exact: true }).inputValue(), wheel.name);
    await page.getByRole("button", { name: "Create the job" }).click();
    await page.getByRole("heading", { name: wheel.name }).waitFor();
    assert.deepEqual((await call("GET", "/v1/jobs")).items[0].gear, wheel.gear);
  },
);

browserTest("fields that a gear of a file fills are not folded", {}, async ({ page, open }) => {
  await open("/jobs/new");
  const tip = page.getByLabel("Tip diameter");
  assert.equal(await tip.isVisible(), false);
  const diameter = '<attribute id="tip_diameter" unit="mm">54.1</attribute>';
  const model = rexsModel().replace('<attribute id="face_width"', `${diameter}<attribute id="face_width"`);
  await page
    .getByLabel("Gear from a file")
    .setInputFiles({ name: "gear.rexs", mimeType: "application/xml", buffer: Buffer.from(model) });
  await page.getByRole("button", { name: "Use", exact: true }).click();
  await tip.waitFor();
  assert.equal(await tip.inputValue(), "54.1");
});

browserTest("a lost answer makes one job", { offline: true }, async ({ page, open, call }) => {
  await open("/jobs/new");
  await page.getByLabel("With gear data").uncheck();
  await page.getByLabel("Name", { exact: true }).fill("Once");
  /** @type {string[]} */
  const keys = [];
  await page.route("**/v1/jobs", async (route) => {
    keys.push(route.request().headers()["idempotency-key"] ?? "");
    // it is stored, but the response is lost
    await route.fetch();
    if (keys.length === 1) return route.abort("connectionreset");
    return route.continue();
  });
  await page.getByRole("button", { name: "Create the job" }).click();
  // nothing else is needed: the page sends it again
  await page.getByRole("heading", { name: "Once" }).waitFor();
  assert.equal(keys.length, 2);
  assert.ok(keys[0] && keys[0] === keys[1], "the same key");
  assert.equal((await call("GET", "/v1/jobs")).items.length, 1);
});
