// Keys: requested when the server requires one, kept in the tab, never in an address.

import assert from "node:assert/strict";
import { createHash } from "node:crypto";
import { browserTest } from "./harness.js";

const KEY = "a-key-for-the-tests";
const serve = [`--api-keys-sha256=${createHash("sha256").update(KEY).digest("hex")}`, "--auth=required"];

browserTest(
  "a key is requested, tried, kept for the tab and forgotten",
  { serve, statuses: [401] },
  async ({ page, open, call }) => {
    await call("POST", "/v1/jobs", { name: "guarded" }, { "x-api-key": KEY });
    await open("/jobs");
    const dialog = page.getByRole("dialog", { name: "API key" });
    await dialog.getByLabel("Key", { exact: true }).fill("wrong");
    await dialog.getByRole("button", { name: "Use this key" }).click();
    await page.getByRole("heading", { name: "Invalid API key" }).waitFor();
    await dialog.getByLabel("Key", { exact: true }).fill(KEY);
    await dialog.getByRole("button", { name: "Use this key" }).click();
    await page.getByText("guarded").waitFor();
    assert.equal(await dialog.count(), 0);
    assert.ok(!page.url().includes(KEY));
    await page.reload();
    await page.getByText("guarded").waitFor();
    assert.equal(await page.evaluate(() => Object.keys(localStorage).filter((name) => name.includes("key")).length), 0);
    await page.getByRole("link", { name: "Settings" }).click();
    await page.getByText("engineer", { exact: true }).waitFor();
    await page.getByRole("button", { name: "Forget the key" }).click();
    await dialog.waitFor();
  },
);

browserTest(
  "a key whose rights were revoked is reported, and can be changed",
  { serve: [...serve, "--api-keys-role=reader"], statuses: [401, 403] },
  async ({ page, server }) => {
    await page.goto(`${server.url}/settings`);
    await page.evaluate((key) => sessionStorage.setItem("flankfit.key", key), KEY);
    // the last response of the server
    await page.route("**/v1/whoami", (route) =>
      route.fulfill({ json: { actor: "key", role: "engineer", scopes: ["read", "compute", "measure", "decide"] } }),
    );
    await page.goto(`${server.url}/jobs/new`);
    await page.getByLabel("With gear data").uncheck();
    await page.getByLabel("Name", { exact: true }).fill("not mine to make");
    await page.getByRole("button", { name: "Create the job" }).click();
    await page.getByText("The current key lacks permission.").waitFor();
    await page.keyboard.press("Escape");
    await page.getByRole("heading", { name: "This key lacks permission" }).waitFor();
    assert.equal(await page.getByLabel("Name", { exact: true }).inputValue(), "not mine to make");
  },
);

browserTest(
  "a key is kept in the browser on request, until it is forgotten",
  { serve, statuses: [401] },
  async ({ page, open, call, server }) => {
    await call("POST", "/v1/jobs", { name: "guarded" }, { "x-api-key": KEY });
    await open("/jobs");
    const dialog = page.getByRole("dialog", { name: "API key" });
    await dialog.getByLabel("Key", { exact: true }).fill(KEY);
    await dialog.getByLabel("Remember in this browser").check();
    await dialog.getByRole("button", { name: "Use this key" }).click();
    await page.getByText("guarded").waitFor();
    const places = () =>
      page.evaluate(() => [sessionStorage, localStorage].map((place) => place.getItem("flankfit.key")));
    assert.deepEqual(await places(), [null, KEY]);
    // another tab has it too, which sessionStorage does not provide
    const tab = await page.context().newPage();
    await tab.goto(`${server.url}/jobs`);
    await tab.getByText("guarded").waitFor();
    assert.equal(await tab.getByRole("dialog").count(), 0);
    await tab.close();
    await open("/settings");
    await page.getByRole("button", { name: "Forget the key" }).click();
    await dialog.waitFor();
    assert.deepEqual(await places(), [null, null]);
  },
);

browserTest("a 403 that another key would not change requests none", { statuses: [403] }, async ({ page, open }) => {
  await page.route("**/v1/jobs", (route) =>
    route.request().method() === "POST"
      ? route.fulfill({
          status: 403,
          contentType: "application/problem+json",
          body: JSON.stringify({
            type: "urn:flankfit:problem:cross_site",
            title: "Another site asks",
            status: 403,
            code: "cross_site",
            detail: "A page of another site may not do this.",
          }),
        })
      : route.continue(),
  );
  await open("/jobs/new");
  await page.getByLabel("With gear data").uncheck();
  await page.getByLabel("Name", { exact: true }).fill("from elsewhere");
  await page.getByRole("button", { name: "Create the job" }).click();
  await page.getByRole("heading", { name: "Another site asks" }).waitFor();
  await page.getByText("A page of another site may not do this.").waitFor();
  assert.equal(await page.getByRole("dialog").count(), 0);
  assert.equal(await page.getByLabel("Name", { exact: true }).inputValue(), "from elsewhere");
});
