// A map as an image for download: title, colours, edges and scale on white.

import { fmt } from "../i18n/i18n.js";
import { css, deviationColour } from "../lib/colour.js";
import { contoursOf, levelsOf } from "./contours.js";
import { scaleLabel } from "./legend.js";
import { heightsOf, imageOf } from "./raster.js";
import { boxOf } from "./surface.js";

const [WIDTH, HEIGHT, LEFT, TOP, BOTTOM] = [1600, 900, 130, 90, 170];

/**
 * @param {{ title: string, about: string, contours: boolean, surface: import("./surface.js").FlankSurface, limit: number, unit?: string | undefined,
 *   axes: import("./heat_map.js").MapAxes, box?: import("./surface.js").Box | undefined, flipU?: boolean,
 *   marks: { root: string, tip: string, faceI: string, faceII: string, material: string } }} map
 * @returns {Promise<Blob>}
 */
export async function pngOf({
  title,
  about,
  contours,
  surface,
  limit,
  unit,
  axes,
  box = boxOf(surface),
  flipU = false,
  marks,
}) {
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [WIDTH, HEIGHT];
  const pen = canvas.getContext("2d");
  if (!pen) throw new Error("no canvas");
  pen.fillStyle = "#fff";
  pen.fillRect(0, 0, WIDTH, HEIGHT);
  const [width, height] = [WIDTH - LEFT - 40, HEIGHT - TOP - BOTTOM];
  const view = { width, height, box, flipU };
  const heights = heightsOf(surface, view);
  pen.putImageData(new ImageData(imageOf(heights, width, limit, 12), width, height), LEFT, TOP);
  if (contours) lines(pen, heights, width, limit);
  pen.strokeStyle = "#333";
  pen.lineWidth = 2;
  pen.strokeRect(LEFT, TOP, width, height);
  const text = (/** @type {string} */ words, /** @type {number} */ x, /** @type {number} */ y, align = "center") => {
    pen.textAlign = /** @type {CanvasTextAlign} */ (align);
    pen.fillText(words, x, y);
  };
  pen.fillStyle = "#111";
  pen.font = "600 30px system-ui, sans-serif";
  text(title, LEFT, 44, "left");
  pen.font = "22px system-ui, sans-serif";
  text(about, LEFT, 78, "left");
  pen.font = "24px system-ui, sans-serif";
  const named = ({ label = "", unit: sign = /** @type {string | undefined} */ ("") }) =>
    sign ? `${label} / ${sign}` : label;
  const edge = (/** @type {number} */ at, /** @type {readonly [number, number]} */ [from, to]) =>
    fmt.value.onScale(at, to - from, "mm");
  const under = TOP + height + 34;
  text(`${edge(box.v[0], box.v)} (${marks.faceI})`, LEFT, under, "left");
  text(`${edge(box.v[1], box.v)} (${marks.faceII})`, LEFT + width, under, "right");
  text(named(axes.v), LEFT + width / 2, under);
  const [above, below] = flipU ? box.u : [box.u[1], box.u[0]];
  text(edge(above, box.u), LEFT - 12, TOP + 22, "right");
  text(marks.tip, LEFT - 12, TOP + 50, "right");
  text(edge(below, box.u), LEFT - 12, TOP + height - 6, "right");
  text(marks.root, LEFT - 12, TOP + height - 34, "right");
  pen.save();
  pen.translate(36, TOP + height / 2);
  pen.rotate(-Math.PI / 2);
  text(named(axes.u), 0, 0);
  pen.restore();
  const bar = 600;
  for (let i = 0; i < bar; i += 1) {
    pen.fillStyle = css(deviationColour((2 * i) / (bar - 1) - 1, 1));
    pen.fillRect(LEFT + i, HEIGHT - 84, 1, 26);
  }
  pen.fillStyle = "#111";
  for (const mark of [-1, -0.5, 0, 0.5, 1]) {
    text(scaleLabel(mark * limit), LEFT + (bar * (mark + 1)) / 2, HEIGHT - 28);
  }
  text(`${unit ?? ""}  ${marks.material}`.trim(), LEFT + bar + 50, HEIGHT - 62, "left");
  return new Promise((resolve, reject) => {
    canvas.toBlob((blob) => (blob ? resolve(blob) : reject(new Error("no image"))), "image/png");
  });
}

/** @param {CanvasRenderingContext2D} pen @param {Float32Array} heights @param {number} width @param {number} limit */
function lines(pen, heights, width, limit) {
  const step = 6;
  const columns = Math.floor(width / step);
  const rows = Math.floor(heights.length / width / step);
  const coarse = Float32Array.from({ length: columns * rows }, (_, i) => {
    const [x, y] = [i % columns, Math.floor(i / columns)];
    return heights[y * step * width + x * step] ?? Number.NaN;
  });
  pen.strokeStyle = "rgb(0 0 0 / 55%)";
  for (const { level, segments } of contoursOf(coarse, columns, levelsOf(limit))) {
    pen.lineWidth = level === 0 ? 3 : 1.2;
    pen.beginPath();
    for (const [x, y, p, q] of segments) {
      pen.moveTo(LEFT + x * step, TOP + y * step);
      pen.lineTo(LEFT + p * step, TOP + q * step);
    }
    pen.stroke();
    const [x, y] = segments[Math.floor(segments.length / 2)] ?? [];
    if (x === undefined || y === undefined || segments.length < 8) continue;
    // contour lines are labelled
    pen.font = "20px system-ui, sans-serif";
    pen.textAlign = "center";
    pen.lineWidth = 5;
    pen.strokeStyle = "rgb(255 255 255 / 85%)";
    const at = /** @type {const} */ ([LEFT + Math.min(columns - 6, Math.max(6, x)) * step, TOP + y * step + 7]);
    pen.strokeText(scaleLabel(level), ...at);
    pen.fillStyle = "#000";
    pen.fillText(scaleLabel(level), ...at);
    pen.strokeStyle = "rgb(0 0 0 / 55%)";
  }
}
