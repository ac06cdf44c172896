// The flank in space: the surface over the nominal plane, deviations magnified. three.js is loaded
// on demand; during rotation a coarser surface is drawn.

import { underway } from "../api/resource.js";
import { t } from "../i18n/flank.js";
import { fmt } from "../i18n/i18n.js";
import { niceAbove } from "../lib/colour.js";
import { query, setQuery } from "../navigation.js";
import { html, useLayoutEffect, useMemo, useRef, useState } from "../../vendor/ui.js";
import { useWidth } from "../charts/chart.js";
import { barLength } from "../charts/k_chart.js";
import {
  CLOSER,
  edgeWords,
  indicesOf,
  linesOf,
  nodeInPicture,
  nodeSeenAt,
  projection,
  thinnedTo,
  verticesOf,
} from "./mesh.js";
import { boxOf, nearestNode, nodeOf } from "./surface.js";

/** @typedef {import("./surface.js").FlankSurface} FlankSurface */
/** @typedef {import("./surface.js").FlankNode} FlankNode */
/** @typedef {import("./mesh.js").Camera} Camera */

const HEIGHT = 420;
/** The movement below which a press is a click, pixels. */
const CLICK = 4;
// limits during rotation: nodes, and pixels per pixel of the page
const COARSE = 3000;
const COARSE_PIXELS = 0.7;
/** From above left, from face I, from above. @type {Record<string, Camera>} */
const VIEWS = {
  1: { yaw: -30, pitch: 35, zoom: 1 },
  2: { yaw: -90, pitch: 12, zoom: 1 },
  3: { yaw: 0, pitch: 89, zoom: 1 },
};
const FIRST = /** @type {Camera} */ (VIEWS[1]);
/** The edges along the width and upwards; whichever way u counts, the tip is above. */
const SIDES = /** @type {const} */ ({ root: [0, -1], tip: [0, 1], faceI: [-1, 0], faceII: [1, 0] });
const LETTERS = { letter: 6.8, line: 14 };
/** The longest scale bar, pixels. Above this many limits it would be meaningless: heights are not visible from there. */
const [BAR, LIMITS] = [75, 4];

/** Returns true if this browser supports WebGL. */
export function hasWebgl() {
  return document.createElement("canvas").getContext("webgl2") !== null;
}

/** The factor by which deviations are magnified, so that the limit is a quarter of the flank. @param {FlankSurface} surface @param {number} limit @param {string | undefined} unit */
export function magnificationOf(surface, limit, unit) {
  const { u, v } = boxOf(surface);
  const size = Math.max(u[1] - u[0], v[1] - v[0]);
  const inMm = unit === "µm" ? 1e-3 : 1;
  return niceAbove((0.18 * size) / (limit * inMm));
}

/**
 * @param {{ surface: FlankSurface, limit: number, unit: string | undefined, name: string, summary: string, flipU: boolean,
 *   at: FlankNode | undefined, onAt: (node: FlankNode) => void, says: (node: FlankNode) => string }} props `at`: the node that
 *   is read out; a click chooses another
 */
export function Flank3d({ surface, limit, unit, name, summary, flipU, at, onAt, says }) {
  const [holder, width] = useWidth();
  const canvas = useRef(/** @type {HTMLCanvasElement | null} */ (null));
  const scene = useRef(/** @type {Awaited<ReturnType<typeof built>> | null} */ (null));
  const [error, setError] = useState(/** @type {unknown} */ (undefined));
  const [ready, setReady] = useState(false);
  const [turning, setTurning] = useState(/** @type {Camera | undefined} */ (undefined));
  const magnification = useMemo(() => magnificationOf(surface, limit, unit), [surface, limit, unit]);
  const scaled = magnification * (unit === "µm" ? 1e-3 : 1);
  const text = query.value.get("camera");
  const camera = useMemo(() => cameraOf(text), [text]);
  const dragged = useRef(/** @type {{ x: number, y: number, from: Camera, now: Camera } | null} */ (null));
  // before the browser paints: see `useResource`
  useLayoutEffect(() => {
    let wanted = true;
    setReady(false);
    if (canvas.current) {
      underway.value += 1;
      built(canvas.current, surface, limit, scaled, flipU)
        .then(
          (made) => {
            if (!wanted) return made.dispose();
            scene.current = made;
            setReady(true);
            return undefined;
          },
          (/** @type {unknown} */ caught) => wanted && setError(caught),
        )
        .finally(() => {
          underway.value -= 1;
        });
    }
    return () => {
      wanted = false;
      scene.current?.dispose();
      scene.current = null;
    };
  }, [surface, limit, magnification, flipU]);
  useLayoutEffect(() => {
    if (ready) scene.current?.draw(camera, width, HEIGHT, false);
  }, [ready, camera, width]);
  const settle = (/** @type {Camera} */ next) =>
    setQuery({ camera: [next.yaw, next.pitch, next.zoom].map((one) => Number(one.toFixed(2))).join(",") });
  const press = (/** @type {KeyboardEvent} */ event) => {
    const turns = /** @type {Record<string, [number, number]>} */ ({
      ArrowLeft: [-5, 0],
      ArrowRight: [5, 0],
      ArrowUp: [0, 5],
      ArrowDown: [0, -5],
    });
    const turn = turns[event.key];
    const view = VIEWS[event.key] ?? (event.key === "0" ? FIRST : undefined);
    const factor = { "+": 1.25, "-": 0.8 }[event.key];
    if (turn) settle(turned(camera, ...turn));
    else if (view) settle(view);
    else if (factor) settle({ ...camera, zoom: Math.min(10, Math.max(0.3, camera.zoom * factor)) });
    else return;
    event.preventDefault();
    event.stopPropagation();
  };
  const move = (/** @type {PointerEvent} */ event) => {
    const drag = dragged.current;
    if (!drag) return;
    if (drag.now === drag.from && Math.hypot(event.clientX - drag.x, event.clientY - drag.y) < CLICK) return;
    drag.now = turned(drag.from, (event.clientX - drag.x) / 3, (event.clientY - drag.y) / 3);
    setTurning(drag.now);
    scene.current?.draw(drag.now, width, HEIGHT, true);
  };
  const frame = { width, height: HEIGHT };
  const project = projection(turning ?? camera, { ...frame, radius: radiusOf(surface) });
  const release = (/** @type {PointerEvent & { currentTarget: Element }} */ event) => {
    const drag = dragged.current;
    dragged.current = null;
    setTurning(undefined);
    if (!drag) return;
    if (drag.now !== drag.from) return settle(drag.now);
    if (event.type === "pointercancel") return;
    const box = event.currentTarget.getBoundingClientRect();
    const place = /** @type {const} */ ([event.clientX - box.left, event.clientY - box.top]);
    const index = nodeSeenAt(surface, scaled, flipU, project, place);
    if (index !== undefined) onAt(nodeOf(surface, index));
  };
  const mark = at && !turning ? nodeInPicture(surface, at.index, scaled, flipU, project) : undefined;
  const edges = useMemo(() => edgeHeights(surface, scaled, flipU), [surface, scaled, flipU]);
  const names = { root: t.root, tip: t.tip, faceI: t.faceI, faceII: t.faceII };
  const words = ready ? edgeWords(boxOf(surface), project, frame, names, SIDES, edges, LETTERS) : [];
  if (error !== undefined) return html`<p class="hint" role="status">${t.noWebgl}</p>`;
  return html`<div class="flank-3d">
    <div class="actions" role="group" aria-label=${t.views}>
      ${Object.entries(VIEWS).map(([key, view]) => html`<button key=${key} type="button" class="button small" onClick=${() => settle(view)}>${key === "1" ? t.view1 : key === "2" ? t.view2 : t.view3}</button>`)}
    </div>
    <div ref=${holder} class="chart-reader" tabindex="0" role="application" aria-roledescription=${t.space} aria-label=${`${name}. ${summary} ${t.turnHint}`}
      data-ready=${ready ? "1" : undefined} onKeyDown=${press}
      onPointerDown=${(/** @type {PointerEvent & { currentTarget: Element }} */ event) => {
        event.currentTarget.setPointerCapture(event.pointerId);
        dragged.current = { x: event.clientX, y: event.clientY, from: camera, now: camera };
      }}
      onPointerMove=${move} onPointerUp=${release} onPointerCancel=${release}>
      <canvas ref=${canvas} width=${width} height=${HEIGHT}></canvas>
      ${
        ready &&
        html`<svg class="chart chart-crosshair" width=${width} height=${HEIGHT} aria-hidden="true">
          ${words.map(({ key, text: word, x, y }) => html`<text key=${key} x=${x} y=${y} dy="0.35em" text-anchor="middle">${word}</text>`)}
          ${heightBar(project, scaled, limit, unit)}
          ${mark && html`<circle cx=${mark[0]} cy=${mark[1]} r="6" />`}
        </svg>`
      }
    </div>
    <p class="picked" role="status" translate="no">${at ? says(at) : ""}</p>
    <p class="hint">${t.magnified(fmt.value.count(magnification))} ${t.turnHint}</p>
  </div>`;
}

/** Returns the heights in the middle of the edges, as drawn. @param {FlankSurface} surface @param {number} scaled @param {boolean} flipU */
function edgeHeights(surface, scaled, flipU) {
  const { u, v } = boxOf(surface);
  const at = (/** @type {readonly [number, number]} */ [across, up]) => {
    const along = (u[0] + u[1] + (flipU ? -up : up) * (u[1] - u[0])) / 2;
    const { z } = nearestNode(surface, along, (v[0] + v[1] + across * (v[1] - v[0])) / 2);
    return Number.isFinite(z) ? z * scaled : 0;
  };
  return { root: at(SIDES.root), tip: at(SIDES.tip), faceI: at(SIDES.faceI), faceII: at(SIDES.faceII) };
}

/**
 * Returns a round height and its length in the picture, where heights are always upright.
 * @param {ReturnType<typeof projection>} project @param {number} scaled @param {number} limit @param {string | undefined} unit
 */
function heightBar(project, scaled, limit, unit) {
  const pixels = project(0, 0, 0)[1] - project(0, 0, scaled)[1];
  const height = barLength(0, pixels, BAR);
  if (height === 0 || height > LIMITS * limit) return null;
  const [x, y] = [14, HEIGHT - 14];
  return html`<g class="height-bar" translate="no">
    <path d=${`M${x - 4} ${y}h8M${x} ${y}v${-height * pixels}m-4 0h8`} />
    <text x=${x + 9} y=${y - (height * pixels) / 2} dy="0.35em">${`${fmt.value.input(height)}${unit ? ` ${unit}` : ""}`}</text>
  </g>`;
}

/** The distance of the camera from the middle of the flank. @param {FlankSurface} surface */
function radiusOf(surface) {
  const { u, v } = boxOf(surface);
  return 0.62 * Math.hypot(u[1] - u[0], v[1] - v[0]);
}

/** @param {Camera} camera @param {number} yaw @param {number} pitch @returns {Camera} */
function turned(camera, yaw, pitch) {
  return {
    ...camera,
    yaw: ((camera.yaw + yaw + 540) % 360) - 180,
    pitch: Math.min(89, Math.max(-89, camera.pitch + pitch)),
  };
}

/** @param {string | null} text @returns {Camera} */
function cameraOf(text) {
  const [yaw = Number.NaN, pitch = Number.NaN, zoom = Number.NaN] = (text ?? "").split(",").map(Number);
  return Number.isFinite(yaw + pitch + zoom) && zoom > 0 ? { yaw, pitch, zoom } : FIRST;
}

/**
 * @param {HTMLCanvasElement} canvas @param {FlankSurface} surface @param {number} limit @param {number} scale of the heights
 * @param {boolean} flipU
 */
async function built(canvas, surface, limit, scale, flipU) {
  const three = await import("../../vendor/three.js");
  const renderer = new three.WebGLRenderer({ canvas, antialias: true, alpha: true });
  const scene = new three.Scene();
  // offset slightly behind the grid lines, which would otherwise flicker
  const material = new three.MeshBasicMaterial({
    vertexColors: true,
    side: three.DoubleSide,
    polygonOffset: true,
    polygonOffsetFactor: 1,
    polygonOffsetUnits: 4,
  });
  const mesh = (/** @type {FlankSurface} */ of) => {
    const { positions, colours } = verticesOf(of, limit, scale, flipU, boxOf(surface));
    const geometry = new three.BufferGeometry();
    geometry.setAttribute("position", new three.BufferAttribute(positions, 3));
    geometry.setAttribute("color", new three.BufferAttribute(colours, 3));
    geometry.setIndex(new three.BufferAttribute(indicesOf(of), 1));
    const made = new three.Mesh(geometry, material);
    scene.add(made);
    return made;
  };
  const fine = mesh(surface);
  const small = thinnedTo(surface, COARSE);
  const coarse = small === surface ? fine : mesh(small);
  const grid = (/** @type {Float32Array} */ positions, /** @type {number} */ colour) => {
    const geometry = new three.BufferGeometry();
    geometry.setAttribute("position", new three.BufferAttribute(positions, 3));
    const lines = new three.LineSegments(
      geometry,
      new three.LineBasicMaterial({ color: colour, transparent: true, opacity: 0.55 }),
    );
    scene.add(lines);
    return lines;
  };
  const lines = [
    grid(linesOf(surface, 0, flipU, boxOf(surface)), 0x5c6874),
    grid(linesOf(surface, scale, flipU, boxOf(surface)), 0x1c242c),
  ];
  const radius = radiusOf(surface);
  const eye = new three.OrthographicCamera(-1, 1, 1, -1, -50 * radius, 50 * radius);
  eye.up.set(0, 0, 1);
  return {
    /** @param {Camera} camera @param {number} width @param {number} height @param {boolean} turning */
    draw({ yaw, pitch, zoom }, width, height, turning) {
      fine.visible = !turning || coarse === fine;
      if (coarse !== fine) coarse.visible = turning;
      renderer.setPixelRatio(turning ? COARSE_PIXELS : Math.min(2, globalThis.devicePixelRatio || 1));
      renderer.setSize(width, height, false);
      const [a, b] = [three.MathUtils.degToRad(yaw - 90), three.MathUtils.degToRad(pitch)];
      eye.position.set(Math.cos(a) * Math.cos(b) * radius, Math.sin(a) * Math.cos(b) * radius, Math.sin(b) * radius);
      eye.lookAt(0, 0, 0);
      const aspect = width / height;
      [eye.left, eye.right, eye.top, eye.bottom] = [
        -radius * Math.max(1, aspect),
        radius * Math.max(1, aspect),
        radius,
        -radius,
      ];
      if (aspect < 1) [eye.top, eye.bottom] = [radius / aspect, -radius / aspect];
      eye.zoom = zoom * CLOSER;
      eye.updateProjectionMatrix();
      renderer.render(scene, eye);
    },
    dispose() {
      for (const one of [fine, coarse, ...lines]) one.geometry.dispose();
      for (const one of lines) one.material.dispose();
      material.dispose();
      renderer.dispose();
    },
  };
}
