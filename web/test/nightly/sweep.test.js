// All checks of every page: accessibility, languages, narrow screens, a reload.

import assert from "node:assert/strict";
import { asTables, graphics } from "../browser/graphics.js";
import { axeFinds, browserTest } from "../browser/harness.js";
import { jumps, pressed, show, strays, watchShifts, wide } from "../browser/looks.js";
import { closes, opens, pageList, visit } from "../browser/pages.js";

/** @typedef {import("../browser/harness.js").World} World */
/** @typedef {import("playwright-core").Page} Page */

const DESK = { width: 1280, height: 800 };
/** A tablet in both orientations. */
const TABLETS = [
  { width: 1000, height: 1024 },
  { width: 768, height: 1024 },
];
const PHONE = { width: 360, height: 740 };

/** The content of the page. @param {Page} page */
const seen = async (page) => ((await page.locator("main").textContent()) ?? "").replaceAll(/\s+/gu, " ").trim();

/**
 * Returns the errors of the current page or dialog: window, theme and language are changed and
 * restored. Each theme is checked by axe, and each width: light on the desk, dark on a tablet.
 * @param {World} world @param {string} [part] that axe looks at, by default the page
 */
async function looked(world, part) {
  const { page } = world;
  /** @type {string[]} */
  const errors = [];
  const add = (/** @type {string} */ where, /** @type {readonly string[]} */ found) =>
    errors.push(...found.map((one) => `${where}: ${one}`));
  add("axe, light", await axeFinds(page, part));
  await show(world, { language: "pseudo" });
  add("not of the tables", await strays(page));
  await show(world, { language: "de" }, PHONE);
  add("360 px, de", await wide(page));
  await show(world, { language: "en", theme: "dark" });
  add("360 px, en", await wide(page));
  for (const tablet of TABLETS) {
    await show(world, {}, tablet);
    const { small, count } = await pressed(page);
    add(`less than 44 px at ${tablet.width} px`, small);
    if (count <= 4) add(`${tablet.width} px`, [`only ${count} targets`]);
  }
  add("axe, dark, on a tablet", await axeFinds(page, part));
  await show(world, { theme: "light" }, DESK);
  return errors;
}

browserTest("every page passes, in each theme, language and width", { settings: { theme: "light" } }, async (world) => {
  const { page, server, loaded } = world;
  /** @type {string[]} */
  const errors = [];
  await watchShifts(page);
  let drawn = 0;
  for (const listed of await pageList(world)) {
    const add = (/** @type {readonly string[]} */ found, name = listed.name) =>
      errors.push(...found.map((one) => `${name}: ${one}`));
    const address = server.url + listed.path;
    add(await jumps(page, () => world.open(listed.path)));
    if (listed.fill) await visit(world, listed);
    const before = await seen(page);
    if (page.url() !== address) add([`is at ${page.url()}`]);
    add(await looked(world));
    // the address has the whole view
    if (!listed.fill) {
      await page.reload();
      await loaded();
      if (page.url() !== address) add([`is at ${page.url()} after a reload`]);
    }
    const after = await seen(page);
    if (after !== before) add([`${before}\nis after a reload, or other languages and widths\n${after}`]);
    for (const dialog of listed.dialogs ?? []) {
      await opens(world, dialog);
      add(await looked(world, "dialog[open]"), dialog.name);
      await closes(world);
    }
    if (listed.name.startsWith("report")) continue;
    const { errors: found, count } = await graphics(page);
    add(found);
    drawn += count;
    await asTables(page);
  }
  assert.deepEqual(errors, []);
  assert.ok(drawn > 40, `${drawn} graphics`);
});
