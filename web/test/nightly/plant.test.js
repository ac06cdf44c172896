// The dashboard on a plant: two servers on one PostgreSQL, and the browser comes by TLS through
// haproxy. Either may be lost at any time, and changes at the other are shown. One plant for all of
// these tests.

import assert from "node:assert/strict";
import { atEnd, counted, doNotSendAgain, example, holdsTheseFiles, inBrowser, withMore } from "../browser/harness.js";
import { lacking, startPlant, until } from "./plant.js";

/** @typedef {import("./plant.js").Plant} Plant */
/** @typedef {import("../browser/harness.js").World["call"]} Call */
/** @typedef {import("playwright-core").Page} Page */
/** @typedef {import("playwright-core").Locator} Locator */
/** @typedef {Pick<import("../browser/harness.js").World, "page" | "open" | "loaded" | "startAgain"> & { plant: Plant }} World */

const why = lacking();
/** Required programs may not be missing. */
const skip = process.env["FLANKFIT_TEST_POSTGRES"] === "required" ? undefined : why;

/** The plant of all these tests. @type {Promise<Plant> | undefined} */
let started;

function plantOfAll() {
  assert.equal(why, undefined);
  started ??= startPlant();
  return started;
}
atEnd(async () => (await started)?.server.stop());

/**
 * @param {string} name
 * @param {Omit<import("../browser/harness.js").Options, "serve" | "browser"> & { role?: import("./plant.js").Role }} options
 *   `role`: whose key the browser has
 * @param {(world: World) => Promise<void>} body
 */
function plantTest(name, { role, ...options }, body) {
  const run = async () => {
    const plant = await plantOfAll();
    await holdsTheseFiles(plant.servers[0].url);
    try {
      await inBrowser(plant.server, { ...options, browser: plant.browser }, async (world) => {
        const { page, open, loaded, startAgain } = world;
        if (role)
          await page.context().addInitScript((key) => {
            sessionStorage.setItem("flankfit.key", key);
          }, plant.keys[role].key);
        await body({ page, open, loaded, startAgain, plant });
      });
    } catch (error) {
      console.error(`--- plant ---\n${plant.server.log()}`);
      throw withMore(error, "plant", plant.server.log().split("\n").slice(-30).join("\n"));
    } finally {
      await plant.both();
      await plant.server.start();
    }
  };
  counted(name, run, skip);
}

/** @param {Call} call @param {string} name */
const newJob = async (call, name) =>
  call("POST", "/v1/jobs", { ...JSON.parse(await example("requests/job.json")), name });
/** @param {Call} call @param {string} id @param {string} [file] */
const measure = async (call, id, file = "flank_z52.json") =>
  call("POST", `/v1/jobs/${id}/iterations`, await example(file));

/** Returns the time at which a document was loaded: another after a reload. @param {Page} page */
const birth = (page) => page.evaluate(() => performance.timeOrigin);

/**
 * Opens a page, and waits until it follows events.
 * @param {Page} page @param {() => Promise<unknown>} opened
 */
async function following(page, opened) {
  const begun = page.waitForResponse((response) => response.url().endsWith("/events"));
  await opened();
  assert.equal((await begun).status(), 200);
}

/**
 * Opens a page of a job, and waits until only events are under way.
 * @param {Page} page @param {() => Promise<unknown>} opened
 */
async function rests(page, opened) {
  let count = 0;
  page.on("request", (request) => {
    if (request.url().includes("/trace?")) count += 1;
  });
  await following(page, opened);
  // once more upon an event
  await until(
    "what is read with the first news",
    async () => count,
    (count) => count >= 2,
  );
  await page.locator('main[aria-busy="false"] h1').waitFor();
}

/** @param {number} side @param {object} more */
function grid(side, more) {
  const axis = Array.from({ length: side }, (_, i) => i);
  const z = axis.map((i) => axis.map((j) => Math.sin(3 * i + 7 * j)));
  const request = { nodes: { type: "grid", u: axis, v: axis, z }, ...more };
  return { name: "grid.json", mimeType: "application/json", buffer: Buffer.from(JSON.stringify(request)) };
}

plantTest("what is stored through another server is shown without a reload", { role: "reader" }, async (world) => {
  const { page, open, loaded, plant } = world;
  const call = plant.at(1);
  const at = (/** @type {string} */ id) => `/v1/jobs/${id}/iterations/1`;
  await plant.only(0);
  await following(page, () => open("/jobs"));
  const born = await birth(page);
  const { id } = await newJob(call, "made elsewhere");
  const row = page.getByRole("row").filter({ hasText: "made elsewhere" });
  await row.getByText("new", { exact: true }).waitFor();
  await measure(call, id);
  await row.getByText("open", { exact: true }).waitFor();

  await following(page, () => row.getByRole("link", { name: "made elsewhere" }).click());
  await page.getByText("Decide on iteration 1").waitFor();
  await call("PATCH", at(id), { decision: "remachine", reason: "seen elsewhere" });
  await measure(call, id, "flank_z52_remachined.json");
  await page.getByText("Decide on iteration 2").waitFor();
  await loaded();
  const rows = page.getByRole("region", { name: "Iterations", exact: true }).locator("tbody tr");
  assert.equal(await rows.count(), 2);

  const views = page.getByRole("navigation", { name: "Views of this job" });
  await following(page, () => views.getByRole("link", { name: "Trace" }).click());
  const refit = { ...JSON.parse(await example("requests/refit.json")), reason: "tried elsewhere" };
  const fit = await call("POST", `${at(id)}/fits`, refit);
  await page.locator(`[data-entry="${fit.id}"]`, { hasText: "tried elsewhere" }).waitFor();
  assert.equal(await birth(page), born, "it is one document all the time");
  // which was never served by the one that stored
  assert.equal(await plant.metric(1, 'flankfit_open_connections{kind="events"}'), 0);
  assert.ok((await plant.metric(0, 'flankfit_open_connections{kind="events"}')) > 0);
});

/** Enters a key into the dialog. @param {Page} page @param {string} key @param {boolean} [remember] */
async function enterKey(page, key, remember = false) {
  const dialog = page.getByRole("dialog", { name: "API key" });
  await dialog.getByLabel("Key", { exact: true }).fill(key);
  await dialog.getByLabel("Remember in this browser").setChecked(remember);
  await dialog.getByRole("button", { name: "Use this key" }).click();
  await dialog.waitFor({ state: "detached" });
}

plantTest("each role is offered what it may do", { role: "reader" }, async ({ page, open, loaded, plant }) => {
  const { id } = await newJob(plant.at(0), "of three roles");
  await measure(plant.at(0), id);
  const button = (/** @type {string} */ name) => page.getByRole("button", { name, exact: true });
  const link = (/** @type {string} */ name) => page.getByRole("link", { name, exact: true });
  /**
   * Follows a link, in the same document, and returns which of these are offered there.
   * @param {Locator} to @param {Locator} seen @param {Record<string, Locator>} named
   */
  const through = async (to, seen, named) => {
    await to.click();
    await seen.waitFor();
    await loaded();
    const found = await Promise.all(Object.entries(named).map(async ([name, one]) => (await one.count()) > 0 && name));
    return found.filter(Boolean);
  };
  await open("/settings");
  for (const [role, may] of /** @type {const} */ ([
    ["reader", []],
    ["operator", ["new job", "measure"]],
    ["engineer", ["new job", "measure", "edit", "accept"]],
  ])) {
    if (role !== "reader") {
      await link("Settings").click();
      await button("Enter a key").click();
      await enterKey(page, plant.keys[role].key);
    }
    await page.getByText(role, { exact: true }).waitFor();
    const views = page.getByRole("navigation", { name: "Views of this job" });
    const found = [
      ...(await through(link("Jobs"), link("of three roles"), { "new job": link("New job") })),
      ...(await through(link("of three roles"), page.getByText("Decide on iteration 1"), {
        measure: views.getByRole("link", { name: "Measure" }),
        edit: button("Edit"),
      })),
      ...(await through(
        views.getByRole("link", { name: "Iteration 1" }),
        page.getByRole("heading", { name: "Decision" }),
        {
          accept: button("Accept"),
        },
      )),
    ];
    assert.deepEqual(found, may, role);
    await page.getByText("may not decide").waitFor({ state: role === "engineer" ? "detached" : "visible" });
  }
});

plantTest(
  "a right revoked while a page is open is reported, and no input is lost",
  { statuses: [401, 403] },
  async ({ page, open, loaded, plant }) => {
    const { id } = await newJob(plant.at(0), "of a lost right");
    await measure(plant.at(0), id);
    const own = await plant.at(0, "admin")("POST", "/v1/keys", { name: "of a tablet", role: "engineer" });
    await page.goto(`${plant.server.url}/settings`);
    await enterKey(page, own.key, true);
    await open(`/jobs/${id}/iterations/1`);
    await page.getByRole("button", { name: "Machine again" }).click();
    const decide = page.getByRole("dialog").filter({ hasText: "iteration 1" });
    await decide.getByLabel("Reason").fill("burnt at the tip");

    // another tab of the browser sets another key, for both
    const tab = await page.context().newPage();
    await tab.goto(`${plant.server.url}/settings`);
    await tab.getByRole("button", { name: "Enter a key" }).click();
    await enterKey(tab, plant.keys.operator.key, true);
    await tab.close();
    await decide.getByRole("button", { name: "Machine again" }).click();
    await page.getByText("The current key lacks permission. Another key may have it.").waitFor();
    await page.keyboard.press("Escape");
    await decide.getByRole("heading", { name: "This key lacks permission" }).waitFor();
    assert.equal(await decide.getByLabel("Reason").inputValue(), "burnt at the tip");
    await decide.getByRole("button", { name: "Machine again" }).click();
    await enterKey(page, own.key, true);
    await decide.getByRole("button", { name: "Machine again" }).click();
    await page.getByText("burnt at the tip").waitFor();
    assert.equal((await plant.at(1)("GET", `/v1/jobs/${id}/iterations/1`)).decision, "remachine");

    // the key is revoked at one server while the page follows through either
    await following(page, () => open(`/jobs/${id}`));
    await page.getByRole("button", { name: "Edit" }).waitFor();
    await plant.at(1, "admin")("DELETE", `/v1/keys/${own.id}`);
    await page.getByRole("dialog", { name: "API key" }).waitFor();
    await following(page, () => enterKey(page, plant.keys.operator.key));
    await loaded();
    await page.getByRole("button", { name: "Edit" }).waitFor({ state: "detached" });
    await measure(plant.at(1), id, "flank_z52_remachined.json");
    await page.getByText("Decide on iteration 2").waitFor();
  },
);

plantTest("what takes long is cancelled through the page", { role: "operator" }, async (world) => {
  const { page, open, plant } = world;
  const { id } = await newJob(plant.at(0), "takes long");
  await open(`/jobs/${id}/measure`);
  // with many more seconds than this test takes
  const model = { type: "polynomial", degree: [8, 8], basis: "chebyshev" };
  await page.setInputFiles("#measure-files", grid(150, { model, estimator: { type: "least_trimmed_squares" } }));
  await page.locator(".queue-entry canvas").waitFor();
  await page.getByRole("button", { name: "Store as iteration" }).click();
  const entry = page.locator(".queue-entry");
  await entry.locator(".progress", { hasText: /[1-9]\d*\s*%/ }).waitFor();
  const share = Number(await entry.locator("progress").getAttribute("value"));
  assert.ok(share > 0 && share < 1, `${share}`);
  const busy = (/** @type {0 | 1} */ which) => plant.metric(which, "flankfit_fit_workers_busy");
  const [ofFirst = 0] = await until(
    "one of them does it",
    async () => [await busy(0), await busy(1)],
    ([first = 0, second = 0]) => first > 0 !== second > 0,
  );
  const doing = ofFirst > 0 ? 0 : 1;
  const other = doing === 0 ? 1 : 0;
  await entry.getByRole("button", { name: "Cancel" }).click();
  await page.getByText("Cancelled. Data that had already arrived may be stored").waitFor();
  await entry.getByText("not sent yet").waitFor();
  await until(
    "the workers",
    () => busy(doing),
    (count) => count === 0,
  );
  assert.deepEqual((await plant.at(other)("GET", `/v1/jobs/${id}/trace`)).iterations, []);
});

plantTest(
  "a server that is killed takes nothing with it that was sent, typed or followed",
  { role: "operator", statuses: [502], offline: true },
  async ({ page, open, plant }) => {
    const { id } = await newJob(plant.at(0), "of a lost server");
    await plant.only(0);
    const looking = await page.context().newPage();
    await rests(looking, () => looking.goto(`${plant.server.url}/jobs/${id}`));
    const born = await birth(looking);
    await rests(page, () => open(`/jobs/${id}/measure`));
    // more than the proxy buffers to send again by itself
    await page.setInputFiles("#measure-files", grid(40, { model: { type: "polynomial", degree: 2 } }));
    await page.locator(".queue-entry canvas").waitFor();
    await page.getByLabel("Operator").fill("A. B.");
    await page.getByLabel("Note").fill("typed before it was lost");
    /** @type {[number, string | undefined][]} */
    const answers = [];
    page.on("response", (response) => {
      const request = response.request();
      if (request.method() === "POST" && request.url().endsWith("/iterations"))
        answers.push([response.status(), request.headers()["idempotency-key"]]);
    });

    // it gives no response; the proxy takes it for lost after some seconds
    const before = await plant.requests(0);
    await plant.servers[0].signal("SIGSTOP");
    await page.getByRole("button", { name: "Store as iteration" }).click();
    await until(
      "the request is at the server",
      () => plant.requests(0),
      (count) => count > before,
    );
    await plant.both();
    await plant.servers[0].signal("SIGKILL");

    await page.waitForURL(`**/jobs/${id}/iterations/1`);
    // the browser reports responses to a test when the page may have gone on; a server that needs
    // more than a second responds with 200 and progress events
    const last = () => answers.at(-1)?.[0] ?? 0;
    await until(
      "the answer",
      async () => last(),
      (status) => [200, 201].includes(status),
    );
    // a proxy gives such a response, or none, and the browser resends as the page does
    const lost = answers.slice(0, -1).map(([status]) => status);
    assert.deepEqual(
      lost.filter((status) => status !== 502),
      [],
    );
    assert.equal(new Set(answers.map(([, key]) => key)).size, 1);
    assert.ok(answers[0]?.[1]);
    const { iterations } = await plant.at(1)("GET", `/v1/jobs/${id}/trace`);
    assert.equal(iterations.length, 1);
    const stored = await plant.at(1)("GET", `/v1/jobs/${id}/iterations/1`);
    assert.deepEqual([stored.operator, stored.note, stored.node_count], ["A. B.", "typed before it was lost", 1600]);

    // the other server sends events to an open page, also for later changes
    await looking.getByText("Decide on iteration 1").waitFor();
    await plant.at(1)("PATCH", `/v1/jobs/${id}/iterations/1`, { decision: "accepted", reason: "good" });
    await looking.getByText("Iteration 1 is accepted").waitFor();
    await looking.locator(".notice").waitFor({ state: "detached" });
    assert.equal(await birth(looking), born, "it is one document all the time");
  },
);

plantTest(
  "while all servers are away the page says so, and keeps what is there",
  { role: "operator", statuses: [502, 503], offline: true },
  async ({ page, open, loaded, startAgain, plant }) => {
    const { id } = await newJob(plant.at(0), "stays");
    await following(page, () => open(`/jobs/${id}/measure`));
    const born = await birth(page);
    await page.getByLabel("Note").fill("typed all the same");
    await Promise.all(plant.servers.map((server) => server.signal("SIGKILL")));
    await page.getByText(/Not updated since \d\d:\d\d:\d\d/).waitFor();
    await page.getByText("stays", { exact: true }).first().waitFor();
    await page.setInputFiles("#measure-files", grid(4, { model: { type: "polynomial", degree: 1 } }));
    await page.locator(".queue-entry canvas").waitFor();
    await page.getByRole("button", { name: "Store as iteration" }).click();
    // visible at the button, at the end of a long page
    const says = "Your input is queued and will be resent";
    const above = (/** @type {string} */ text) =>
      [...document.querySelectorAll(".notice")].some(
        (one) => one.textContent?.includes(text) && one.getBoundingClientRect().top >= 0,
      );
    await until("the notice", () => page.evaluate(above, says), Boolean);
    await doNotSendAgain(page);
    await page.locator(".queue-entry").getByRole("heading", { name: "The server is not responding" }).waitFor();
    await page.locator(".queue-entry").getByText("no response", { exact: true }).waitFor();
    await startAgain();
    await loaded();
    assert.equal(await page.getByLabel("Note").inputValue(), "typed all the same");
    assert.equal(await birth(page), born, "it is one document all the time");
    await page.getByRole("button", { name: "Store as iteration" }).click();
    await page.waitForURL(`**/jobs/${id}/iterations/1`);
    assert.equal((await plant.at(1)("GET", `/v1/jobs/${id}/trace`)).iterations.length, 1);
  },
);

plantTest("all requests of a page go to the proxy, by TLS alone", { role: "engineer" }, async (world) => {
  const { page, open, plant } = world;
  const { url } = plant.server;
  const { id } = await newJob(plant.at(0), "by TLS");
  await measure(plant.at(0), id);
  /** @type {import("playwright-core").Response[]} */
  const responses = [];
  page.on("response", (response) => responses.push(response));
  for (const place of ["/jobs", `/jobs/${id}/measure`, `/jobs/${id}/iterations/1`, `/jobs/${id}/report`])
    await open(place);
  /** Returns all responses that came from one place. */
  const byPlace = async () => {
    /** @type {Map<string, Record<string, string>[]>} */
    const known = new Map();
    for (const response of responses.filter((one) => !/^(blob|data):/.test(one.url())))
      known.set(response.url(), [...(known.get(response.url()) ?? []), await response.allHeaders()]);
    return [...known];
  };
  // responses from the browser's own cache do not count, and may be reported first
  const strict = (/** @type {Record<string, string>} */ one) => one["strict-transport-security"] === "max-age=31536000";
  const known = await until("what comes by TLS", byPlace, (all) => all.every(([, answers]) => answers.some(strict)));
  for (const [place, answers] of known) {
    assert.equal(new URL(place).origin, url);
    const headers = answers.find(strict);
    assert.ok(headers, `${place} ${JSON.stringify(answers)}`);
    assert.equal(headers["x-content-type-options"], "nosniff", place);
    assert.match(headers["content-security-policy"] ?? "", /default-src 'none'.*frame-ancestors 'none'/, place);
    assert.equal(headers["set-cookie"], undefined, place);
  }
  assert.ok(known.length > 60, `${known.length}`);
  const document = await responses.find((response) => response.url() === `${url}/jobs`)?.allHeaders();
  assert.ok(document);
  const policy = (document["content-security-policy"] ?? "").split("; ");
  for (const rule of ["script-src 'self'", "connect-src 'self'", "form-action 'none'"])
    assert.ok(policy.includes(rule));
  assert.deepEqual(
    [document["cross-origin-opener-policy"], document["referrer-policy"]],
    ["same-origin", "no-referrer"],
  );
  const safe = await page.evaluate(() => [isSecureContext, document["cookie"], location.protocol]);
  assert.deepEqual(safe, [true, "", "https:"]);
  assert.deepEqual(await page.context().cookies(), []);
  // the browser may use no other connection, and the servers' internal endpoints are not available
  const again = await page.context().newPage();
  const byHttp = await again.goto(`${url.replace("https:", "http:")}/metrics`);
  assert.deepEqual([byHttp?.url(), byHttp?.status()], [`${url}/metrics`, 404]);
  assert.equal((await byHttp?.allHeaders())?.["strict-transport-security"], "max-age=31536000");
});
