// The worker that reads files, and the one policy of trusted types: for the worker's own file.

import { OfflineError } from "../api/problem.js";

/** @typedef {import("./read.js").Content} Content */

/** @type {Worker | undefined} */
let worker;
let last = 0;
/** @type {Map<number, { resolve: (content: Content) => void, reject: (error: Error) => void }>} */
const waiting = new Map();

/** Starts the worker before it is needed, since the server may be away by then. */
export function started() {
  if (worker) return worker;
  const own = new URL("./worker.js", import.meta.url).href;
  const { trustedTypes } =
    /** @type {{ trustedTypes?: { createPolicy: (name: string, rules: object) => { createScriptURL: (url: string) => string } } }} */ (
      /** @type {unknown} */ (globalThis)
    );
  const policy = trustedTypes?.createPolicy("assets", {
    createScriptURL: (/** @type {string} */ url) => {
      if (url !== own) throw new TypeError("not the worker of the dashboard");
      return url;
    },
  });
  worker = new Worker(policy ? policy.createScriptURL(own) : own, { type: "module" });
  worker.addEventListener("message", ({ data: { turn, content } }) => {
    waiting.get(turn)?.resolve(content);
    waiting.delete(turn);
  });
  worker.addEventListener("error", (event) => {
    event.preventDefault();
    worker = undefined;
    for (const { reject } of waiting.values()) reject(new OfflineError("no worker"));
    waiting.clear();
  });
  return worker;
}

/** Returns the contents of a file. @param {File} file @returns {Promise<Content>} */
export async function contentOf(file) {
  const bytes = await file.arrayBuffer();
  last += 1;
  const turn = last;
  return new Promise((resolve, reject) => {
    waiting.set(turn, { resolve, reject });
    started().postMessage({ turn, name: file.name, bytes }, [bytes]);
  });
}
