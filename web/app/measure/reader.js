// The worker that reads files, and the one policy of trusted types: for the worker's own file.

/** @typedef {import("./read.js").Content} Content */

/** @type {Worker | undefined} */
let worker;
let last = 0;
/** @type {Map<number, (content: Content) => void>} */
const waiting = new Map();

function started() {
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
    waiting.get(turn)?.(content);
    waiting.delete(turn);
  });
  return worker;
}

/** What is in a file. @param {File} file @returns {Promise<Content>} */
export async function contentOf(file) {
  const bytes = await file.arrayBuffer();
  last += 1;
  const turn = last;
  return new Promise((resolve) => {
    waiting.set(turn, resolve);
    started().postMessage({ turn, name: file.name, bytes }, [bytes]);
  });
}
