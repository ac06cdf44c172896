// The time of a search and of the list with 10,000 jobs.

import { browserTest } from "../browser/harness.js";
import { median, ROUNDS } from "./rounds.js";

const JOBS = 10_000;
const AT_ONCE = 32;
const LISTS = 200;

/** Creates the jobs: every tenth on another machine, the last one changed last. @param {import("../browser/harness.js").World} world */
async function made({ call }) {
  let next = 0;
  const worker = async () => {
    while (next < JOBS) {
      const i = next;
      next += 1;
      const machine = `grinder ${i % 10}`;
      await call("POST", "/v1/jobs", { name: `Gear ${String(i).padStart(5, "0")}`, serial_number: `S${i}`, machine });
    }
  };
  await Promise.all(Array.from({ length: AT_ONCE }, worker));
}

browserTest("10,000 jobs", {}, async (world) => {
  const { page, open, loaded, call } = world;
  await made(world);
  await open("/jobs");
  // from the last key of a search to its rows
  await page.evaluate(() => {
    const seen = { key: 0, rows: 0, wanted: "" };
    Object.assign(window, { seen });
    const look = () => {
      const links = [...document.querySelectorAll("tbody th a")].map((one) => one.textContent ?? "");
      if (seen.wanted && links.length > 0 && links.every((name) => name.includes(seen.wanted))) {
        seen.rows = performance.now();
        seen.wanted = "";
      }
      requestAnimationFrame(look);
    };
    look();
    addEventListener("keydown", () => {
      seen.key = performance.now();
    });
  });
  /** @type {number[]} */
  const times = [];
  const search = page.getByLabel("Search");
  for (let round = 0; round < ROUNDS; round += 1) {
    const wanted = `0${round + 3}12`;
    await search.fill(wanted.slice(0, -1));
    await loaded();
    await page.evaluate((name) => Object.assign(/** @type {any} */ (window).seen, { rows: 0, wanted: name }), wanted);
    await search.press(wanted.slice(-1));
    const took = await page.waitForFunction(() => {
      const { key, rows } = /** @type {any} */ (window).seen;
      return rows > 0 && rows - key;
    });
    times.push(Number(await took.jsonValue()));
    await page.waitForFunction((text) => location.search === `?q=${text}`, wanted);
  }
  const rows = median(times);
  console.log(`key to rows ${rows.toFixed(0)} ms (${times.map((one) => one.toFixed(0)).join(", ")})`);

  // the list itself, by pages, filters and searches in turn, one request at a time
  const paths = [
    "/v1/jobs?limit=50",
    "/v1/jobs?limit=50&machine=grinder+7",
    "/v1/jobs?limit=50&q=04711",
    "/v1/jobs?limit=50&sort=name",
    "/v1/jobs?limit=50&status=new",
  ];
  /** @type {number[]} */
  const lists = [];
  for (let i = 0; i < LISTS; i += 1) {
    const from = performance.now();
    await call("GET", /** @type {string} */ (paths[i % paths.length]));
    lists.push(performance.now() - from);
  }
  const p95 = lists.sort((a, b) => a - b)[Math.ceil(0.95 * LISTS) - 1] ?? Number.POSITIVE_INFINITY;
  console.log(`a list of 10,000 jobs: 95 in 100 within ${p95.toFixed(1)} ms`);
});
