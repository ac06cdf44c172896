// Runs the tests of a folder: `node test/run.js browser 2` (or `nightly 2`), all of its files in
// two processes that each keep their browser and their server; `node test/run.js bench`, a process
// for each file. Omitted tests are listed, and written to the file FLANKFIT_LEFT_OUT.

import { fork } from "node:child_process";
import { appendFile, readdir } from "node:fs/promises";
import { fileURLToPath } from "node:url";

/** @typedef {import("node:child_process").ChildProcess} ChildProcess */
/** @typedef {{ count: number, failed: string[], leftOut: string[] }} Outcome of a file: its tests, those that have failed, and those that were left out */

const [folder = "browser", workers] = process.argv.slice(2);
const worker = fileURLToPath(new URL("worker.js", import.meta.url));

/** The longest files, which begin first. */
const LONG = ["report.test.js", "story.test.js"];

/** The time after which a test is taken to hang. */
const LONGEST_MS = 1_200_000;

/** @param {string} name */
const place = (name) => (LONG.includes(name) ? LONG.indexOf(name) : LONG.length);

/**
 * Has a process run a file, and returns its results, or its end.
 * @param {ChildProcess} child @param {string} name @returns {Promise<Outcome>}
 */
function outcome(child, name) {
  return new Promise((resolve) => {
    const ended = (/** @type {number | null} */ code) => {
      clearTimeout(late);
      resolve({ count: 0, failed: [`(the process ended with ${code})`], leftOut: [] });
    };
    child.once("exit", ended);
    const late = setTimeout(() => child.kill("SIGKILL"), LONGEST_MS);
    child.once("message", (answer) => {
      clearTimeout(late);
      child.off("exit", ended);
      resolve(/** @type {Outcome} */ (answer));
    });
    child.send(name);
  });
}

/**
 * Ends a process, and fails if it has failed although none of its tests has.
 * @param {ChildProcess} child @param {boolean} failed
 */
async function end(child, failed) {
  if (child.exitCode !== null || child.signalCode !== null) return;
  const ended = new Promise((resolve) => child.once("exit", resolve));
  child.disconnect();
  const code = await ended;
  if (code !== 0 && !failed) throw new Error(`a process of tests ended with ${code}, and no test had failed`);
}

/**
 * Takes one file after another from a list until it is empty.
 * @param {string[]} names @param {boolean} separate whether each has a process of its own
 * @param {(name: string, outcome: Outcome) => void} report
 */
async function work(names, separate, report) {
  while (names.length > 0) {
    const child = fork(worker, [folder], { execArgv: ["--test-reporter=spec"] });
    let failing = false;
    do {
      const name = /** @type {string} */ (names.shift());
      const { count, failed, leftOut } = await outcome(child, name);
      failing ||= failed.length > 0;
      const errors = count === 0 && failed.length === 0 ? ["(there is no test in it)"] : failed;
      report(name, { count, failed: errors, leftOut });
    } while (!separate && child.connected && names.length > 0);
    await end(child, failing);
  }
}

const files = (await readdir(new URL(`${folder}/`, import.meta.url)))
  .filter((name) => name.endsWith(".test.js"))
  .sort();
if (files.length === 0) throw new Error(`there are no tests in ${folder}/`);
const names = [...files].sort((a, b) => place(a) - place(b));
let all = 0;
/** @type {string[]} */
const errors = [];
/** @type {string[]} */
const last = [];
const report = (/** @type {string} */ name, /** @type {Outcome} */ { count, failed, leftOut }) => {
  all += count;
  last.push(...leftOut.map((one) => `left out: ${one}`));
  errors.push(...failed.map((one) => `${name}: ${one}`));
};
await Promise.all(Array.from({ length: Number(workers ?? 1) }, () => work(names, workers === undefined, report)));

console.log(`${all} tests of ${files.length} files, ${errors.length} failed`);
for (const one of errors) console.log(`failed: ${one}`);
for (const one of last) console.log(one);
const record = process.env["FLANKFIT_LEFT_OUT"];
if (record && last.length > 0) await appendFile(record, `${last.join("\n")}\n`);
process.exitCode = errors.length > 0 ? 1 : 0;
