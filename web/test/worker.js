// A process of run.js: runs the files that it is told, one after another, and says of each what has failed.

import { close, settled } from "./browser/harness.js";

const folder = process.argv[2];

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
  process.send?.({ count, failed: [...unread, ...failed], leftOut });
}

process.on("message", (name) => void run(name));
process.on("disconnect", () => void close());
