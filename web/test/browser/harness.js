// Browser tests: the real program on a port of its own, the system's Chromium, and watchers that
// fail a test if the page misbehaves. Tests of one process share a browser, and a server if they
// look at their own jobs alone.

import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { createHash } from "node:crypto";
import { existsSync } from "node:fs";
import { mkdtemp, readdir, readFile, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import path from "node:path";
import readline from "node:readline";
import { after, test } from "node:test";
import { setTimeout as pause } from "node:timers/promises";
import { fileURLToPath } from "node:url";
import { chromium } from "playwright-core";

/** @typedef {import("playwright-core").Page} Page */
/** @typedef {import("playwright-core").BrowserContext} Context */
/** @typedef {import("playwright-core").BrowserContextOptions} ContextOptions */
/**
 * @typedef {object} Server
 * @property {string} url
 * @property {string} folder
 * @property {() => string} log
 * @property {() => Promise<void>} start
 * @property {() => Promise<void>} stop
 * @property {(name: NodeJS.Signals) => Promise<void>} signal waits for its end where the signal ends it
 */

const web = fileURLToPath(new URL("../..", import.meta.url));
const root = path.dirname(path.resolve(web));

/** The program under test. */
export function program() {
  const target = process.env["CARGO_TARGET_DIR"] ?? path.join(root, "target");
  const found = process.env["FLANKFIT_BIN"] ?? path.join(target, "debug", "flankfit");
  assert.ok(existsSync(found), `${found} is not there: cargo build, or say FLANKFIT_BIN`);
  return found;
}

/** Browsers, by their additional arguments. @type {Map<string, Promise<import("playwright-core").Browser>>} */
const browsers = new Map();
/** The server of the tests that only look at their own jobs. @type {Promise<Server> | undefined} */
let shared;

/** Other cleanups. @type {(() => Promise<unknown>)[]} */
const ends = [];

/** Registers a cleanup for the end of this process's tests. @param {() => Promise<unknown>} end */
export const atEnd = (end) => ends.push(end);

/** Ends what the tests of this process have shared. */
export async function close() {
  for (const browser of browsers.values()) await (await browser).close();
  if (shared) await ended(await shared);
  for (const end of ends) await end();
}

/** @param {Server} server */
async function ended(server) {
  await server.stop();
  await rm(server.folder, { recursive: true, force: true });
}

// test/worker.js runs one file after another, and closes by itself
if (!process.send) after(close);

/** The renderer: not a GPU in software, unless a test measures times. */
const QUICK = ["--disable-gpu-compositing", "--disable-gpu-rasterization", "--disable-accelerated-2d-canvas"];
let quick = true;

/** Paints as a browser does by default, without cached files: for benches. */
export function asOnScreen() {
  quick = false;
}

/** Contexts by their options, for reuse by tests: a browser need not read the files again. @type {Map<string, Context>} */
const idle = new Map();

/** Two browsers: the first is the same engine without a window around each page, which costs more than most pages do. */
const BROWSERS = ["chromium-headless-shell", "chromium", "chromium-browser", "google-chrome"].map(
  (name) => `/usr/bin/${name}`,
);

/** @param {readonly string[]} more arguments */
function chromiumBrowser(more = []) {
  const executablePath = [process.env["CHROMIUM"], ...BROWSERS].find((place) => place && existsSync(place));
  assert.ok(executablePath, "no Chromium: web/setup, or say CHROMIUM");
  // headless Chromium has no WebGL without the first two; containers have little shared memory
  const webgl = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader"];
  const args = [...webgl, ...(quick ? QUICK : []), "--disable-dev-shm-usage", "--no-sandbox", "--lang=en-GB", ...more];
  const key = more.join(" ");
  const browser = browsers.get(key) ?? chromium.launch({ executablePath, args });
  browsers.set(key, browser);
  return browser;
}

/**
 * Starts the program; on the same port again after `stop` and `start`.
 * @param {readonly string[]} options of `flankfit serve`, each as `--name=value`
 * @returns {Promise<Server>}
 */
export async function serve(options = []) {
  const folder = await mkdtemp(path.join(tmpdir(), "flankfit-web-"));
  const given = (/** @type {string} */ name) => options.some((option) => option.startsWith(name));
  const defaults = [
    ...(given("--database-url") ? [] : [`--database-url=sqlite://${path.join(folder, "test.db")}`]),
    ...(given("--auth") || given("--api-keys") ? [] : ["--auth=off"]),
  ];
  let address = options.find((option) => option.startsWith("--bind="))?.slice("--bind=".length) ?? "127.0.0.1:0";
  const others = options.filter((option) => !option.startsWith("--bind="));
  let log = "";
  /** @type {import("node:child_process").ChildProcess | undefined} */
  let child;
  const server = {
    url: "",
    folder,
    log: () => log,
    start: async () => {
      const started = spawn(program(), ["serve", `--bind=${address}`, ...defaults, ...others], {
        stdio: ["ignore", "ignore", "pipe"],
        env: { ...process.env, NO_COLOR: "1" },
      });
      child = started;
      address = await new Promise((resolve, reject) => {
        readline.createInterface({ input: started.stderr }).on("line", (line) => {
          log += `${line}\n`;
          const found = /listening on https?:\/\/([\d.:]+)/.exec(line)?.[1];
          if (found) resolve(found);
        });
        started.once("exit", (code) => reject(new Error(`the server ended (${code}):\n${log}`)));
      });
      server.url = `http://${address}`;
    },
    stop: () => server.signal("SIGTERM"),
    signal: (/** @type {NodeJS.Signals} */ name) =>
      /** @type {Promise<void>} */ (
        new Promise((resolve) => {
          if (!child || child.exitCode !== null || child.signalCode !== null) return resolve();
          if (name === "SIGTERM" || name === "SIGKILL") child.once("exit", () => resolve());
          else resolve();
          return child.kill(name);
        })
      ),
  };
  await server.start();
  return server;
}

/** @type {Promise<void> | undefined} */
let compared;

/** Fails if the program was built from other files than those in this folder. @param {string} url */
export async function holdsTheseFiles(url) {
  compared ??= comparesFiles(url);
  await compared;
}

/** @param {string} url */
async function comparesFiles(url) {
  if (process.env["FLANKFIT_DASHBOARD_DIR"]) return;
  const index = await (await fetch(`${url}/`)).text();
  const served = /\/assets\/(\w+)\//.exec(index)?.[1];
  /** @type {[string, Buffer][]} */
  const files = [["index.html", await readFile(path.join(web, "index.html"))]];
  for (const folder of ["app", "vendor"]) {
    for (const entry of await readdir(path.join(web, folder), { recursive: true, withFileTypes: true })) {
      if (!entry.isFile() || entry.name.endsWith(".d.ts")) continue;
      const file = path.join(entry.parentPath, entry.name);
      files.push([path.relative(web, file).replaceAll(path.sep, "/"), await readFile(file)]);
    }
  }
  files.sort(([a], [b]) =>
    a === "index.html" ? 1 : b === "index.html" ? -1 : Buffer.compare(Buffer.from(a), Buffer.from(b)),
  );
  const hash = createHash("sha256");
  for (const [name, bytes] of files) hash.update(length(name)).update(name).update(length(bytes)).update(bytes);
  assert.equal(served, hash.digest("hex"), "the program holds other files than web/: cargo build");
}

/** @param {string | Buffer} bytes */
function length(bytes) {
  const size = Buffer.alloc(8);
  size.writeBigUInt64LE(BigInt(Buffer.byteLength(bytes)));
  return size;
}

/**
 * @typedef {object} Options
 * @property {readonly string[]} [serve] options of `flankfit serve`
 * @property {readonly number[]} [statuses] refusals that the test provokes: the browser's own lines about them are no errors
 * @property {boolean} [offline] the test takes the server away
 * @property {boolean} [alone] the test counts what the server holds: it has one of its own
 * @property {ContextOptions} [context] of the browser
 * @property {{ language?: string, theme?: string, shortcuts?: boolean }} [settings] of the dashboard
 * @property {readonly string[]} [browser] arguments of a browser of its own
 */

/**
 * @typedef {object} World
 * @property {Page} page
 * @property {Server} server
 * @property {(path: string) => Promise<void>} open goes to a page and waits until it is loaded
 * @property {() => Promise<void>} loaded waits until all of the page is there
 * @property {() => Promise<void>} startAgain starts a server that was stopped, and waits until the page knows
 * @property {(method: string, path: string, body?: unknown, headers?: Record<string, string>) => Promise<any>} call the interface
 * @property {(change?: object) => Promise<any>} job makes one of examples/requests/job.json
 * @property {(jobId: string, file?: string) => Promise<any>} iteration measures, by a file of examples/
 * @property {() => Promise<void>} accessible fails where axe finds something
 */

/** The running and waiting tests of this process. @type {Promise<unknown>[]} */
const begun = [];
/** @type {string[]} */
const failed = [];
/** Omitted tests, with the reasons. @type {string[]} */
const leftOut = [];

/** Waits for all tests so far, and returns their number and the names of the failed and the omitted ones. */
export async function settled() {
  const count = begun.length;
  await Promise.all(begun.splice(0));
  return { count, failed: failed.splice(0), leftOut: leftOut.splice(0) };
}

/**
 * Registers a test that counts among those of its file.
 * @param {string} name @param {() => Promise<void>} run @param {string} [why] it is left out
 */
export function counted(name, run, why) {
  if (why) leftOut.push(`${name} (${why})`);
  const counting = async () => {
    try {
      await run();
    } catch (error) {
      failed.push(name);
      throw error;
    }
  };
  begun.push(test(name, { skip: why ?? false }, counting));
}

/**
 * Registers a test with a page of its own, and with a server of its own if it configures it, stops
 * it or counts its contents.
 * @param {string} name @param {Options} options @param {(world: World) => Promise<void>} body
 */
export function browserTest(name, options, body) {
  const own = options.serve !== undefined || options.offline === true || options.alone === true;
  counted(name, async () => {
    shared ??= own ? undefined : serve();
    const server = await (own ? serve(options.serve) : /** @type {Promise<Server>} */ (shared));
    try {
      await holdsTheseFiles(server.url);
      await inBrowser(server, options, body);
    } catch (error) {
      throw withMore(error, "server", server.log().split("\n").slice(-15).join("\n"));
    } finally {
      if (own) await ended(server);
    }
  });
}

/**
 * Returns the error with more context in its message and in its stack, which is what is printed.
 * @param {unknown} error @param {string} of @param {string} text
 */
export function withMore(error, of, text) {
  if (!(error instanceof Error)) return error;
  const { message, stack } = error;
  error.message = `${message}\n--- ${of} ---\n${text}`;
  if (stack) error.stack = stack.replace(message, () => error.message);
  return error;
}

/** @param {Options} options */
async function newContext(options) {
  const context = await (await chromiumBrowser(options.browser)).newContext({
    viewport: { width: 1280, height: 800 },
    locale: "en-GB",
    timezoneId: "Europe/Berlin",
    reducedMotion: "reduce",
    ...options.context,
  });
  // the longest wait of a test; more on a busy machine
  context.setDefaultTimeout(Number(process.env["FLANKFIT_WAIT_MS"] ?? 30_000));
  return context;
}

/** A page with empty storage except for its settings. @param {Context} context @param {Server} server @param {Options} options */
async function newPage(context, server, { settings = {} }) {
  const page = await context.newPage();
  const session = await context.newCDPSession(page);
  const storageTypes = "local_storage,indexeddb,cookies,cache_storage,service_workers";
  await session.send("Storage.clearDataForOrigin", { origin: server.url, storageTypes });
  await session.detach();
  await page.addInitScript((settings) => {
    if (localStorage.getItem("flankfit.settings") === null)
      localStorage.setItem("flankfit.settings", JSON.stringify(settings));
  }, settings);
  return page;
}

/** @param {Server} server @param {Options} options @param {(world: World) => Promise<void>} body */
export async function inBrowser(server, options, body) {
  const key = JSON.stringify(options.context ?? {});
  const context = (options.browser ? undefined : idle.get(key)) ?? (await newContext(options));
  if (!options.browser) idle.delete(key);
  const page = await newPage(context, server, options);
  const errors = watch(page, server, options);
  // a clock that has been set stays with the context
  let kept = quick && !options.browser;
  const install = page.clock.install.bind(page.clock);
  page.clock.install = (at) => {
    kept = false;
    return install(at);
  };
  try {
    await body(world(page, server));
    assert.deepEqual(errors, [], "the page did what it must not");
  } catch (error) {
    kept = false;
    if (process.env["FLANKFIT_SHOT"]) await page.screenshot({ path: process.env["FLANKFIT_SHOT"], fullPage: true });
    const texts = page.locator(".notices, main").allTextContents().catch(String);
    const shown = await Promise.race([texts, pause(2000, "the page does not answer")]);
    const inShort = String(shown).replace(/\s+/g, " ").slice(0, 600);
    throw withMore(error, "page", [page.url(), inShort, ...errors].join("\n"));
  } finally {
    if (kept) {
      for (const one of context.pages()) await one.close();
      idle.set(key, context);
    } else await context.close();
  }
}

/** Messages of the browser for a lost server: they depend on what was under way. */
const LOST =
  /net::ERR_(CONNECTION_(REFUSED|RESET|CLOSED)|EMPTY_RESPONSE|INCOMPLETE_CHUNKED_ENCODING|HTTP2_PROTOCOL_ERROR|INTERNET_DISCONNECTED)/;

/**
 * Cancels resending of requests without a response; on a busy machine the last try may be over by
 * now.
 * @param {Page} page
 */
export const doNotSendAgain = (page) =>
  page
    .getByRole("button", { name: "Do not resend" })
    .click({ timeout: 15_000 })
    .catch(() => {});

/** @param {Page} page @param {Server} server @param {Options} options */
function watch(page, server, { statuses = [], offline = false }) {
  /** @type {string[]} */
  const errors = [];
  page.on("pageerror", (error) => errors.push(`error: ${error.stack ?? error.message}`));
  page.on("console", (message) => {
    if (message.type() !== "error" && message.type() !== "warning") return;
    const text = message.text();
    // software rendering reads each frame of WebGL back, and says that this is slow
    if (/GL Driver Message .*GPU stall due to ReadPixels/.test(text)) return;
    const status = /^Failed to load resource: the server responded with a status of (\d+)/.exec(text)?.[1];
    if (status && statuses.includes(Number(status))) return;
    if (offline && LOST.test(text)) return;
    errors.push(`console: ${text} (${message.location().url})`);
  });
  page.on("request", (request) => {
    const url = new URL(request.url());
    if (!["data:", "blob:"].includes(url.protocol) && url.origin !== server.url)
      errors.push(`foreign: ${request.url()}`);
  });
  return errors;
}

/** Returns when the page has been painted again. @param {Page} page */
export function painted(page) {
  return page.evaluate(
    () =>
      new Promise((done) => {
        requestAnimationFrame(() => setTimeout(done));
        // a hidden page has no frames: the dashboard goes on after 100 ms there
        setTimeout(done, 1000);
      }),
  );
}

/** @param {Page} page @param {Server} server @returns {World} */
function world(page, server) {
  const loaded = async () => {
    const heading = page.locator('main[aria-busy="false"] h1').first();
    do {
      await heading.waitFor();
      // work after painting comes behind the next frame (shortcuts, permissions of the
      // caller), and may send further requests
      await painted(page);
    } while (!(await heading.isVisible()));
  };
  const call = callOf(server);
  return {
    page,
    server,
    loaded,
    call,
    open: async (place) => {
      await page.goto(server.url + place);
      await loaded();
    },
    job: async (change = {}) =>
      call("POST", "/v1/jobs", { ...JSON.parse(await example("requests/job.json")), ...change }),
    iteration: async (jobId, file = "flank_z52.json") =>
      call("POST", `/v1/jobs/${jobId}/iterations`, await example(file)),
    accessible: async () => assert.deepEqual(await axeFinds(page), [], "axe"),
    startAgain: async () => {
      await server.start();
      // the page also retries by itself, and then there is nothing to press any more
      const pressed = page.getByRole("button", { name: "Retry now" }).click();
      pressed.catch(() => {});
      await page.getByText("Not updated since").waitFor({ state: "detached" });
    },
  };
}

/** Calls the interface of a server. @param {Server} server @param {Record<string, string>} [always] headers @returns {World["call"]} */
export function callOf(server, always = {}) {
  return async (method, place, body, headers = {}) => {
    const response = await fetch(server.url + place, {
      method,
      headers: { ...(body === undefined ? {} : { "content-type": "application/json" }), ...always, ...headers },
      ...(body === undefined ? {} : { body: typeof body === "string" ? body : JSON.stringify(body) }),
    });
    const text = await response.text();
    assert.ok(response.ok, `${method} ${place}: ${response.status} ${text}`);
    return text === "" ? undefined : JSON.parse(text);
  };
}

/** A file of examples/, as text. @param {string} name */
export function example(name) {
  return readFile(path.join(root, "examples", name), "utf8");
}

const RULES = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"];
/** @type {Promise<string> | undefined} */
let axe;

/** Returns the violations that axe finds on a page, or on a part of it. @param {Page} page @param {string} [part] */
export async function axeFinds(page, part) {
  axe ??= readFile(path.join(web, "node_modules", "axe-core", "axe.min.js"), "utf8");
  // as the browser's own tools do, which the policy of the page does not bind
  if (await page.evaluate(() => !("axe" in window))) await page.evaluate(await axe);
  return page.evaluate(
    async ([values, part]) => {
      const { axe } = /** @type {any} */ (window);
      const result = await axe.run(part ?? document, { runOnly: { type: "tag", values }, resultTypes: ["violations"] });
      return result.violations.map(
        (/** @type {any} */ one) =>
          `${one.id}: ${one.help}\n  ${one.nodes.map((/** @type {any} */ node) => `${node.html} ${node.failureSummary}`).join("\n  ")}`,
      );
    },
    /** @type {const} */ ([RULES, part]),
  );
}
