// The same steps in two ways: by pointer, or by keyboard alone.

import assert from "node:assert/strict";

/** @typedef {import("playwright-core").Page} Page */
/** @typedef {import("playwright-core").Locator} Locator */
/**
 * @typedef {object} Hands
 * @property {(target: Locator) => Promise<void>} press a link or a button
 * @property {(target: Locator, text: string) => Promise<void>} type into a field, replacing its text
 * @property {(target: Locator, files: Parameters<Page["setInputFiles"]>[1]) => Promise<void>} pick files
 */

/** @param {Page} page @returns {Hands} */
export function pointer(page) {
  return {
    press: (target) => target.click(),
    type: (target, text) => target.fill(text),
    // a pointer presses the label of the field
    pick: async (target, files) => {
      const chooser = page.waitForEvent("filechooser");
      await page.locator(`label[for="${await target.getAttribute("id")}"]`).click();
      await (await chooser).setFiles(files);
    },
  };
}

/** A limit above the number of elements of any page. */
const MOST_STOPS = 300;

/** Tab, Enter and letters. @param {Page} page @returns {Hands} */
export function keyboard(page) {
  // a listener has the browser hand over its choosers, which takes longer than a key: so from the
  // start on
  page.on("filechooser", () => {});
  const reach = async (/** @type {Locator} */ target) => {
    await target.first().waitFor({ state: "attached" });
    const element = await target.first().elementHandle();
    assert.ok(element);
    for (let stops = 0; stops < MOST_STOPS; stops += 1) {
      if (await element.evaluate((one) => one === document.activeElement)) {
        const seen = await element.evaluate((one) => {
          const box = one.getBoundingClientRect();
          return { outline: getComputedStyle(one).outlineStyle, width: box.width };
        });
        assert.ok(seen.outline !== "none" || seen.width <= 2, "what has the focus shows it");
        return;
      }
      await page.keyboard.press("Tab");
    }
    assert.fail(`the keyboard does not reach ${target}`);
  };
  return {
    press: async (target) => {
      await reach(target);
      await page.keyboard.press("Enter");
    },
    type: async (target, text) => {
      await reach(target);
      await page.keyboard.press("ControlOrMeta+a");
      await page.keyboard.insertText(text);
    },
    pick: async (target, files) => {
      await reach(target);
      const chooser = page.waitForEvent("filechooser");
      await page.keyboard.press("Enter");
      await (await chooser).setFiles(files);
    },
  };
}
