// Every graphic has a name, a sentence and its numbers as a table.

import assert from "node:assert/strict";

/** @typedef {import("playwright-core").Page} Page */

/** The element that holds a graphic with the button of its table. */
const HOLDERS = "figure, .flank-view, .lambda-map, .measure-preview, .all-teeth";

/** Returns the errors of the graphics of a page, and their number. @param {Page} page */
export function graphics(page) {
  return page.evaluate((holders) => {
    const text = (/** @type {string | null} */ ids) =>
      (ids ?? "")
        .split(" ")
        .map((id) => document.getElementById(id)?.textContent?.trim() ?? "")
        .join(" ")
        .trim();
    /** @type {string[]} */
    const errors = [];
    const drawn = [...document.querySelectorAll("main svg, main canvas")].filter((one) => one.checkVisibility());
    // signs with words have no meaning of their own; a canvas and its overlay are one graphic
    const graphics = new Set(
      drawn.flatMap((one) => {
        const reader = one.closest(".chart-reader, [role=slider], [role=application]");
        if (reader) return [reader];
        if (one.getAttribute("aria-hidden") === "true") return [];
        return [one];
      }),
    );
    for (const one of graphics) {
      const label = `${one.tagName}.${one.getAttribute("class")}`;
      const name = one.getAttribute("aria-label") ?? text(one.getAttribute("aria-labelledby"));
      if (!name) errors.push(`${label} has no name`);
      if (one instanceof SVGElement && one.getAttribute("role") !== "img") errors.push(`${label} ${name} has no role`);
      // signs in tables: the row, and its file, have their values
      if (one.closest("td, th")) continue;
      // the sentence of a picture follows its name
      const said = text(one.getAttribute("aria-describedby")) || (name.split(". ")[1] ?? "");
      if (!said) errors.push(`${label} ${name} says nothing`);
      const holder = one.closest(holders);
      // the small map of a tooth is in the table of all of them, and large below
      const teeth = one.closest(".tooth-map") && holder?.closest(".all-teeth")?.querySelector("table");
      const button = [...(holder?.querySelectorAll("button") ?? [])].find(
        (of) => of.textContent?.trim() === "As table",
      );
      if (!teeth && !button) errors.push(`${label} ${name} has no table`);
    }
    return { errors, count: graphics.size };
  }, HOLDERS);
}

/** Presses each «as table» of a page at once, and waits until each has a table with rows. @param {Page} page */
export async function asTables(page) {
  for (let guard = 0; guard < 5; guard += 1) {
    const pressed = await page.evaluate((holders) => {
      const left = [...document.querySelectorAll("main button")].filter(
        (one) => one.textContent?.trim() === "As table" && one.getAttribute("aria-pressed") !== "true",
      );
      for (const one of left) {
        one.closest(holders)?.setAttribute("data-looked", "");
        if (one instanceof HTMLElement) one.click();
      }
      return left.length;
    }, HOLDERS);
    await page.locator("[data-looked]:not(:has(tbody tr))").first().waitFor({ state: "detached" });
    if (pressed === 0) return;
  }
  assert.fail("there is no end of graphics");
}
