// On tablets what is pressed is 44 px high and wide, whatever it is.

import assert from "node:assert/strict";
import { browserTest } from "./harness.js";
import { pageList, visit } from "./pages.js";

const PRESSED =
  "a[href], button, input, select, textarea, summary, label.checkbox, label.button, [role=slider], [role=application]";
const WIDTHS = /** @type {const} */ ([768, 1000]);

/** What is too small of a page, and of how many. @param {import("playwright-core").Page} page */
function pressed(page) {
  return page.evaluate((pressed) => {
    // the label is what is pressed of a box; what is hidden until the keyboard reaches it is not pressed
    const apart = "input[type=checkbox], input[type=radio], .visually-hidden, .skip, [aria-hidden=true] *";
    const inSentence = (/** @type {Element} */ one) => {
      const sentence = one.closest("p, li, dd");
      const more = sentence?.textContent?.trim() !== one.textContent?.trim();
      return one.tagName === "A" && getComputedStyle(one).display === "inline" && sentence !== null && more;
    };
    const all = [...document.querySelectorAll(pressed)].filter(
      (one) => one.checkVisibility() && !one.matches(apart) && !inSentence(one),
    );
    const small = all.flatMap((one) => {
      const { width, height } = one.getBoundingClientRect();
      if (Math.min(width, height) >= 43.5) return [];
      return [`${one.tagName} ${one.getAttribute("class")} ${one.textContent} ${width} × ${height}`];
    });
    return { small: [...new Set(small)], count: all.length };
  }, PRESSED);
}

browserTest(
  `targets are 44 px high and wide on tablets, ${WIDTHS.join(" and ")} px wide`,
  { context: { viewport: { width: WIDTHS[0], height: 1024 } } },
  async (world) => {
    const { page } = world;
    /** @type {string[]} */
    const faults = [];
    for (const listed of await pageList(world)) {
      await visit(world, listed);
      // a tablet is turned: each page is loaded once, and measured at every width
      for (const width of WIDTHS) {
        await page.setViewportSize({ width, height: 1024 });
        const { small, count } = await pressed(page);
        faults.push(...small.map((one) => `${listed.name} at ${width}: ${one}`));
        assert.ok(count > 4, `${listed.name} at ${width}: ${count}`);
      }
      await page.setViewportSize({ width: WIDTHS[0], height: 1024 });
    }
    assert.deepEqual(faults, []);
  },
);
