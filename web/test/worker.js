// A process of run.js: runs files one after another, and reports the failed tests of each.

import { close, settled } from "./browser/harness.js";

const folder = process.argv[2];

/** Unhandled rejections. @type {string[]} */
const stray = [];
for (const event of /** @type {const} */ (["unhandledRejection", "uncaughtException"]))
  process.on(event, (/** @type {unknown} */ error) => {
    console.error(error);
    stray.push(`(${event}: ${error})`);
    process.exitCode = 1;
  });

/** @param {unknown} name of a file */
async function run(name) {
  console.log(`— ${name}`);
  /** @type {string[]} */
  const unread = [];
  try {
    await import(new URL(`${folder}/${name}`, import.meta.url).href);
  } catch (error) {
    console.error(error);
    unread.push("(it cannot be loaded)");
  }
  const { count, failed, leftOut } = await settled();
  process.send?.({ count, failed: [...unread, ...failed, ...stray.splice(0)], leftOut });
}

process.on("message", (name) => void run(name));
process.on("disconnect", () => void close());
