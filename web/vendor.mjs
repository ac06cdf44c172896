// Bundles the libraries of package-lock.json into vendor/, one file for each purpose, with their
// licences: `node vendor.mjs [FOLDER]`. The same versions give the same bytes.
import { mkdir, readFile, readdir, writeFile } from "node:fs/promises";
import path from "node:path";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const here = path.dirname(fileURLToPath(import.meta.url));
const folder = path.resolve(process.argv[2] ?? path.join(here, "vendor"));

/** The exports of each bundle, and the packages of its types. */
const bundles = {
  ui: `
    export { Fragment, cloneElement, createContext, createRef, h, isValidElement, render, toChildArray } from "preact";
    export {
      useCallback, useContext, useEffect, useErrorBoundary, useId, useLayoutEffect, useMemo, useReducer, useRef,
      useState,
    } from "preact/hooks";
    export { batch, computed, effect, signal, untracked, useComputed, useSignal, useSignalEffect } from "@preact/signals";
    import htm from "htm";
    import { h, options } from "preact";
    // Preact sets properties, and any text counts as true for this one: the attribute's own words
    // are meant (but SVG has no such property: there the words are set unchanged)
    const made = options.vnode;
    const drawn = new Set(["svg", "g", "text", "tspan"]);
    options.vnode = (vnode) => {
      const { translate } = vnode.props;
      const { type } = vnode;
      if (typeof type === "string" && typeof translate === "string" && !drawn.has(type)) vnode.props.translate = translate !== "no";
      made?.(vnode);
    };
    export const html = htm.bind(h);
  `,
  api: `export { default as createClient } from "openapi-fetch";`,
  d3: `
    export { bisector, extent, max, mean, median, min, quantileSorted, range, tickStep, ticks } from "d3-array";
    export { contours } from "d3-contour";
    export { Delaunay } from "d3-delaunay";
    export { scaleBand, scaleLinear, scaleLog, scaleTime } from "d3-scale";
    export { area, curveMonotoneX, curveStepAfter, line } from "d3-shape";
  `,
  three: `
    export {
      AmbientLight, BufferAttribute, BufferGeometry, Color, DirectionalLight, DoubleSide, DynamicDrawUsage, Float32BufferAttribute,
      Group, LineBasicMaterial, LineSegments, MathUtils, Mesh, MeshBasicMaterial, MeshLambertMaterial, OrthographicCamera,
      PerspectiveCamera, Points, PointsMaterial, Raycaster, Scene, SRGBColorSpace, Vector2, Vector3, WebGLRenderer,
    } from "three";
  `,
};

await mkdir(folder, { recursive: true });
/** @type {Set<string>} */
const packages = new Set();
for (const [name, contents] of Object.entries(bundles)) {
  const result = await build({
    stdin: { contents, resolveDir: here, sourcefile: `${name}.js` },
    absWorkingDir: here,
    // packages keep their names where node_modules is a link
    preserveSymlinks: true,
    bundle: true,
    format: "esm",
    target: "es2022",
    minify: true,
    legalComments: "none",
    metafile: true,
    write: false,
    outfile: `${name}.js`,
    // set explicitly, as the bundle has no file of its own to resolve from
    define: { "process.env.NODE_ENV": '"production"' },
  });
  for (const input of Object.keys(result.metafile.inputs)) {
    const match = /^node_modules\/((?:@[^/]+\/)?[^/]+)\//.exec(input);
    if (match?.[1]) packages.add(match[1]);
  }
  const [output] = result.outputFiles;
  if (!output) throw new Error(`no output for ${name}`);
  await writeFile(path.join(folder, `${name}.js`), output.contents);
}

let licences = "The files beside this one are bundles of these packages, each under the licence below its name.\n";
for (const name of [...packages].sort()) {
  const place = path.join(here, "node_modules", name);
  const { version, license } = JSON.parse(await readFile(path.join(place, "package.json"), "utf8"));
  const file = (await readdir(place)).find((entry) => /^licen[cs]e(\.|$)/i.test(entry));
  if (!file) throw new Error(`${name} has no licence`);
  if (!["MIT", "ISC", "Apache-2.0", "Unlicense"].includes(license)) throw new Error(`${name} is under ${license}`);
  const text = (await readFile(path.join(place, file), "utf8"))
    .replace(/\r\n/g, "\n")
    .replace(/[ \t]+$/gm, "")
    .trim();
  licences += `\n${"=".repeat(80)}\n${name} ${version} (${license})\n${"=".repeat(80)}\n\n${text}\n`;
}
// the colour maps lie in app/lib/colour_maps.js
const maps = (await readFile(path.join(here, "licences", "crameri.txt"), "utf8")).trim();
licences += `\n${"=".repeat(80)}\nScientific colour maps batlow and vik, version 8 (MIT)\n${"=".repeat(80)}\n\n${maps}\n`;
await writeFile(path.join(folder, "LICENSES.txt"), licences);
