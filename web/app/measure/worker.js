// Reads files outside the page, which stays responsive meanwhile.

import { readFile } from "./read.js";

addEventListener("message", ({ data: { turn, name, bytes } }) => {
  postMessage({ turn, content: readFile(name, new Uint8Array(bytes)) });
});
