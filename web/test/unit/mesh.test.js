// The visible node at a place of the picture of a flank in space.

import assert from "node:assert/strict";
import { test } from "node:test";
import { edgeWords, nodeInPicture, nodeSeenAt, projection } from "../../app/flank/mesh.js";
import { gridOf } from "../../app/flank/surface.js";

const FRAME = { width: 600, height: 400, radius: 10 };
const flat = gridOf(
  [0, 4, 8],
  [0, 5, 10, 15],
  [
    [0, 0, 0, 0],
    [0, 0, 0, 0],
    [0, 0, 0, 0],
  ],
);

test("from above the picture is the map: toe left, tip above", () => {
  const project = projection({ yaw: 0, pitch: 90, zoom: 1 }, FRAME);
  // 400 pixels show 2 × 10 / 1.6
  const pixels = (400 * 1.6) / 20;
  const [x, y] = nodeInPicture(flat, 0, 1, false, project);
  assert.ok(Math.abs(x - (300 - 7.5 * pixels)) < 1e-9 && Math.abs(y - (200 + 4 * pixels)) < 1e-9, `${x} ${y}`);
  const [flippedX, flippedY] = nodeInPicture(flat, 0, 1, true, project);
  assert.ok(Math.abs(flippedX - x) < 1e-9 && Math.abs(flippedY - (400 - y)) < 1e-9);
});

test("each node is found where it is drawn, whatever the view", () => {
  for (const yaw of [-150, -30, 0, 75])
    for (const pitch of [-60, 20, 35, 89]) {
      const project = projection({ yaw, pitch, zoom: 1.3 }, FRAME);
      const middle = nodeInPicture(flat, 5, 1, false, project);
      for (let index = 0; index < 12; index += 1) {
        const [x, y] = nodeInPicture(flat, index, 1, false, project);
        // a little inwards, since a corner is at the edge
        const at = /** @type {const} */ ([x + (middle[0] - x) / 50 + 1e-6, y + (middle[1] - y) / 50 + 1e-6]);
        assert.equal(nodeSeenAt(flat, 1, false, project, at), index, `${yaw} ${pitch} ${index}`);
      }
      assert.equal(nodeSeenAt(flat, 1, false, project, [-5, -5]), undefined);
    }
});

test("a fold hides what lies behind it", () => {
  const fold = gridOf(
    [0, 1, 2],
    [0, 10],
    [
      [0, 0],
      [9, 9],
      [0, 0],
    ],
  );
  // from the root, low: the slope that rises towards the viewer hides the other
  const project = projection({ yaw: 0, pitch: 10, zoom: 1 }, FRAME);
  const [top, below] = [nodeInPicture(fold, 2, 1, false, project), nodeInPicture(fold, 0, 1, false, project)];
  const at = /** @type {const} */ ([top[0] + 5, (top[1] + 2 * below[1]) / 3]);
  assert.equal(nodeSeenAt(fold, 1, false, project, at), 0);
  const behind = projection({ yaw: 180, pitch: 10, zoom: 1 }, FRAME);
  const far = nodeInPicture(fold, 5, 1, false, behind);
  const crest = nodeInPicture(fold, 3, 1, false, behind);
  assert.equal(nodeSeenAt(fold, 1, false, behind, [far[0] + 5, (crest[1] + 2 * far[1]) / 3]), 5);
});

test("where a node is missing, nothing is seen", () => {
  const holed = gridOf(
    [0, 1],
    [0, 1],
    [
      [0, null],
      [0, 0],
    ],
  );
  const project = projection({ yaw: 0, pitch: 90, zoom: 1 }, { width: 100, height: 100, radius: 1 });
  const [x, y] = nodeInPicture(holed, 1, 1, false, project);
  assert.equal(nodeSeenAt(holed, 1, false, project, [x - 2, y - 2]), undefined);
});

const WORDS = { root: "root", tip: "tip", faceI: "face I", faceII: "face II" };
const SIDES = /** @type {const} */ ({ root: [0, -1], tip: [0, 1], faceI: [-1, 0], faceII: [1, 0] });
const SIZE = { letter: 7, line: 14 };
const BOX = /** @type {import("../../app/flank/surface.js").Box} */ ({ u: [0, 8], v: [0, 15] });
/** @param {import("../../app/flank/mesh.js").Camera} camera @param {Partial<Record<keyof typeof WORDS, number>>} [heights] */
const wordsSeen = (camera, heights = {}) => {
  const level = { root: 0, tip: 0, faceI: 0, faceII: 0, ...heights };
  const words = edgeWords(BOX, projection(camera, FRAME), FRAME, WORDS, SIDES, level, SIZE);
  return Object.fromEntries(words.map(({ key, x, y }) => [key, { x, y }]));
};

test("words are outside of the edges that they name", () => {
  const { root, tip, faceI, faceII } = wordsSeen({ yaw: 0, pitch: 90, zoom: 1 });
  assert.ok(root && tip && faceI && faceII);
  assert.ok(tip.y < 200 - 4 * 32 && root.y > 200 + 4 * 32 && Math.abs(tip.x - 300) < 1e-9);
  assert.ok(faceI.x < 300 - 7.5 * 32 && faceII.x > 300 + 7.5 * 32);
  const { root: lower } = wordsSeen({ yaw: 0, pitch: 35, zoom: 1 }, { root: -2 });
  const { root: level } = wordsSeen({ yaw: 0, pitch: 35, zoom: 1 });
  assert.ok(lower && level && lower.y > level.y + 30, "below a surface that falls there");
});

test("words stay in the picture, and along the flank the nearer hides the farther", () => {
  for (const { x, y } of Object.values(wordsSeen({ yaw: 30, pitch: 40, zoom: 10 })))
    assert.ok(x > 0 && x < 600 && y > 0 && y < 400, `${x} ${y}`);
  const { faceI, faceII } = wordsSeen({ yaw: -90, pitch: 0, zoom: 1 });
  assert.ok(faceI && !faceII);
});
