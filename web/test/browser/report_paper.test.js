// The report on paper: as wide as A4, to the stated scale, and no heading alone at the foot of a page.

import assert from "node:assert/strict";
import path from "node:path";
import { readFile } from "node:fs/promises";
import { browserTest, example } from "./harness.js";
import { printed, run, story } from "./paper.js";

const MM = 72 / 25.4;
const LANGUAGES = /** @type {const} */ ({
  en: { ruler: "this bar is 100 mm long", magnification: /Deviation (\d+):1, length (\d+):1/ },
  de: { ruler: "Dieser Balken ist 100 mm lang", magnification: /Abweichung (\d+):1, Länge (\d+):1/ },
});

/**
 * Returns extents on paper, mm, of the lines of a page that are drawn with a given pen width.
 * @param {string} svg of pdftocairo @param {number} pen
 */
function linesOf(svg, pen) {
  const lines = [...svg.matchAll(/<path style="([^"]*)" d="([^"]*)" transform="matrix\(([^)]*)\)"/g)];
  return lines.flatMap(([, style = "", d = "", matrix = ""]) => {
    if (!style.includes(`stroke-width:${pen};`)) return [];
    const [a = 0, , , scale = 0] = matrix.split(",").map(Number);
    const numbers = (d.match(/-?[\d.]+/g) ?? []).map(Number);
    const [x, y] = [0, 1].map((odd) => numbers.filter((_, i) => i % 2 === odd));
    const extent = (/** @type {number[]} */ all, /** @type {number} */ by) =>
      (by * (Math.max(...all) - Math.min(...all))) / MM;
    return [{ points: numbers.length / 2, wide: extent(x ?? [], a), high: extent(y ?? [], Math.abs(scale)) }];
  });
}

/** @param {number} found @param {number} wanted @param {string} what */
const measures = (found, wanted, what) =>
  assert.ok(Math.abs(found - wanted) <= 0.2, `${what}: ${found} mm for ${wanted}`);

for (const [lang, words] of Object.entries(LANGUAGES))
  browserTest(`paper is A4 and to scale, and headings stay with what they head (${lang})`, {}, async (world) => {
    const { page, open, call, server } = world;
    // with limits a figure has more columns, and a trace its K-bands
    const { requirements } = JSON.parse(await example("requests/job_requirements.json"));
    const id = await story(world, { requirements });
    const at = `/v1/jobs/${id}/iterations`;
    await call("POST", `${at}/2/evaluations`, await example("requests/gear_evaluate.json"));
    await call("POST", `${at}/2/pitch`, JSON.parse(await example("requests/iteration_pitch.json")));
    await call("POST", `${at}/2/correction`, JSON.parse(await example("requests/iteration_correction.json")));
    await open(`/jobs/${id}/report?lang=${lang}`);
    const plain = (/** @type {string} */ text) => text.replaceAll(/\s+/gu, "").toLowerCase();
    const headings = (await page.locator(".report :is(h2, h3, h4, thead tr)").allTextContents()).map(plain);
    const bars = await page.locator(".report .k-scale text").allTextContents();
    const { file, pages } = await printed(world);

    // nothing is wider than the page, which would make all of it smaller
    const { stdout: boxes } = await run("pdftotext", ["-bbox", file, "-"], { maxBuffer: 1 << 26 });
    const ends = [...boxes.matchAll(/<word xMin="([\d.]+)" yMin="[\d.]+" xMax="([\d.]+)"/g)];
    assert.ok(ends.length > 500, `${ends.length} words`);
    for (const [word, left, right] of ends)
      assert.ok(Number(left) / MM > 14.5 && Number(right) / MM < 195.5, `beyond the margins: ${word}`);

    // measured with a ruler on paper
    const number = 1 + pages.findIndex((text) => text.includes(words.ruler));
    assert.ok(number > 0, "there is a bar to be measured");
    const drawing = path.join(server.folder, `page-${lang}.svg`);
    await run("pdftocairo", ["-svg", "-f", String(number), "-l", String(number), file, drawing]);
    const svg = await readFile(drawing, "utf8");
    const ruler = linesOf(svg, 0.5).filter(({ points }) => points === 2);
    assert.equal(ruler.length, 1);
    measures(ruler[0]?.wide ?? 0, 100, "the bar of 100 mm");

    // charts and their bars are to the scale stated below them
    const [, deviation = 0, length = 0] = (words.magnification.exec(pages[number - 1] ?? "") ?? []).map(Number);
    assert.ok(deviation >= 100 && length >= 1, `${deviation}, ${length}`);
    const drawn = linesOf(svg, 1.25).filter(({ points }) => points === 2);
    const [across, along] = [drawn.filter(({ wide }) => wide > 1), drawn.filter(({ high }) => high > 1)];
    assert.ok(across.length > 0 && across.length === along.length, `${across.length}, ${along.length}`);
    const barLength = (/** @type {string} */ unit) =>
      Number(
        bars
          .find((text) => text.endsWith(unit))
          ?.replace(",", ".")
          .replace(unit, ""),
      );
    for (const { wide } of across) measures(wide, (barLength("µm") * deviation) / 1000, `${barLength("µm")} µm`);
    for (const { high } of along) measures(high, barLength("mm") * length, `${barLength("mm")} mm`);

    // measured curves have their true extent
    const { traces } = JSON.parse(await example("requests/gear_evaluate.json"));
    const [first] = traces.filter((/** @type {any} */ one) => one.kind === "profile" && one.flank === "left");
    const range = (/** @type {number[]} */ all) => Math.max(...all) - Math.min(...all);
    const [thin] = linesOf(svg, 0.75);
    measures(thin?.wide ?? 0, (range(first.deviation_um) * deviation) / 1000, "deviations of the first trace");

    // no page ends with a heading or a table head
    const { stdout } = await run("pdftotext", ["-layout", file, "-"], { maxBuffer: 1 << 26 });
    for (const [i, text] of stdout.split("\f").slice(0, -1).entries()) {
      const lines = text.split("\n").flatMap((line) => plain(line) || []);
      assert.match(lines.at(-1) ?? "", /\d+\/\d+$/, "the number of the page");
      assert.ok(!headings.includes(lines.at(-2) ?? ""), `page ${i + 1} ends with ${lines.at(-2)}`);
    }
  });
