// Reads files beside the page, so that the page answers meanwhile.

import { readFile } from "./read.js";

addEventListener("message", ({ data: { turn, name, bytes } }) => {
  postMessage({ turn, content: readFile(name, new Uint8Array(bytes)) });
});
