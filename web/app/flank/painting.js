// Maps are painted in parts, between which the page stays responsive; of several requested
// paintings only the last is done.

import { underway } from "../api/resource.js";
import { turn } from "../lib/turn.js";
import { useEffect, useLayoutEffect, useRef } from "../../vendor/ui.js";
import { heightsInParts, imageInParts } from "./raster.js";

/** @typedef {import("./surface.js").FlankSurface} FlankSurface */
/** @typedef {{ surface: FlankSurface, view: import("./raster.js").View, limit: number, density: number }} Picture */

/** The longest time for which the page is blocked, in milliseconds. */
const PART_MS = 8;

/** @template Made @param {import("./raster.js").InParts<Made>} parts @returns {Promise<Made>} */
async function between(parts) {
  for (let from = performance.now(); ; ) {
    const { done, value } = parts.next();
    if (done) return value;
    if (performance.now() - from < PART_MS) continue;
    await turn();
    from = performance.now();
  }
}

/**
 * Keeps a canvas painted. A map shows its last picture until the next one is complete; `main` is
 * busy until it is.
 * @param {Picture} picture @param {readonly unknown[]} changes what it depends on
 */
export function usePainting(picture, changes) {
  const canvas = useRef(/** @type {HTMLCanvasElement | null} */ (null));
  const wanted = useRef(/** @type {Picture | undefined} */ (undefined));
  const running = useRef(false);
  const run = async () => {
    if (running.current) return;
    running.current = true;
    underway.value += 1;
    try {
      // the first layout often changes once more before anything is visible
      await turn();
      for (let now = wanted.current; now; now = wanted.current) {
        wanted.current = undefined;
        await paint(canvas.current, now);
      }
    } finally {
      running.current = false;
      underway.value -= 1;
    }
  };
  useLayoutEffect(() => {
    wanted.current = picture;
    void run();
  }, changes);
  useEffect(
    () => () => {
      wanted.current = undefined;
    },
    [],
  );
  return canvas;
}

/** @param {HTMLCanvasElement | null} canvas @param {Picture} picture */
async function paint(canvas, { surface, view, limit, density }) {
  const [width, height] = [Math.round(view.width * density), Math.round(view.height * density)];
  const heights = await between(heightsInParts(surface, { ...view, width, height }));
  const pixels = await between(imageInParts(heights, width, limit, 7 * density));
  if (!canvas) return;
  canvas.width = width;
  canvas.height = height;
  canvas.getContext("2d")?.putImageData(new ImageData(pixels, width, height), 0, 0);
}
