// The flank of a job's last iteration as a tiny map.

import { fmt } from "../i18n/i18n.js";
import { t } from "../i18n/requirements.js";
import { SURFACE_FIGURES } from "../lib/requirements.js";
import { COLUMNS, pixelsOf, ROWS } from "../lib/thumbnail.js";
import { html, useLayoutEffect, useRef } from "../../vendor/ui.js";

/**
 * @param {{ figures: import("../lib/thumbnail.js").ShortFigures, flank: import("../lib/thumbnail.js").FlankSide | undefined, limit: number }} props
 *   `limit`: of its colours, µm
 */
export function Thumbnail({ figures, flank, limit }) {
  const canvas = useRef(/** @type {HTMLCanvasElement | null} */ (null));
  useLayoutEffect(() => {
    const image = new ImageData(pixelsOf({ figures, flank }, limit), COLUMNS, ROWS);
    canvas.current?.getContext("2d")?.putImageData(image, 0, 0);
  }, [JSON.stringify(figures), flank, limit]);
  const words = SURFACE_FIGURES.flatMap(({ name, symbol }) => {
    const value = figures[/** @type {const} */ (`${name}_um`)];
    return value === undefined ? [] : [`${symbol.replace("_", "")} ${fmt.value.um(value)}\u202fµm`];
  }).join(", ");
  return html`<canvas class="thumbnail" ref=${canvas} width=${COLUMNS} height=${ROWS} role="img"
    aria-label=${t.thumbnail(words, flank)}></canvas>`;
}
