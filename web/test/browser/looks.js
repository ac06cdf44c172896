// Checks of every page, each as the errors of the page that is shown.

/** @typedef {import("playwright-core").Page} Page */
/** @typedef {import("playwright-core").Route} Route */
/** @typedef {{ value: number, what: string[] }} Shift */

/** The limit of moving parts of the window, weighted by distance; 0.1 is commonly called good. */
const MOST = 0.02;

/** Counts layout shifts while pages load. @param {Page} page */
export async function watchShifts(page) {
  await page.addInitScript(() => {
    /** @type {{ value: number, what: string[] }[]} */
    const shifts = [];
    Object.assign(window, { shifts });
    new PerformanceObserver((list) => {
      for (const entry of /** @type {any[]} */ (list.getEntries())) {
        if (entry.hadRecentInput) continue;
        const what = entry.sources.map(
          (/** @type {any} */ { node }) => (node?.className || node?.id) ?? node?.textContent,
        );
        shifts.push({ value: entry.value, what });
      }
    }).observe({ type: "layout-shift", buffered: true });
  });
}

/** Returns true for a request to the interface, except for events. @param {URL} url */
const ofInterface = ({ pathname }) => pathname.startsWith("/v1/") && !pathname.endsWith("/events");

/**
 * Returns the layout shifts of a page. Responses are let through one at a time, the last request
 * first, each painted before the next one: a worse order than on any machine.
 * @param {Page} page @param {() => Promise<void>} open
 */
export async function jumps(page, open) {
  /** @type {Route[]} */
  const held = [];
  let letting = false;
  // the page may have gone on to the next one, which does not need earlier requests
  const gone = () => undefined;
  const letThrough = async () => {
    letting = true;
    for (;;) {
      await painted(page).catch(gone);
      const route = held.pop();
      if (!route) break;
      await route.continue().catch(gone);
      const response = await route.request().response().catch(gone);
      await response?.finished().catch(gone);
    }
    letting = false;
  };
  await page.route(ofInterface, (route) => {
    // which shows all of its data, much of it, at once
    if (page.url().endsWith("/report")) return route.continue();
    held.push(route);
    return letting ? undefined : letThrough();
  });
  await open();
  await page.unroute(ofInterface);
  return jumped(page);
}

/** Returns the shifts since the page was loaded. @param {Page} page */
async function jumped(page) {
  // the browser reports painted frames
  await painted(page);
  const shifts = await page.evaluate(() => /** @type {{ shifts: Shift[] }} */ (/** @type {any} */ (window)).shifts);
  const sum = shifts.reduce((all, { value }) => all + value, 0);
  const text = shifts.map(({ value, what }) => `${value.toFixed(3)} ${what}`).join("; ");
  return sum < MOST ? [] : [`${sum.toFixed(3)} of the window has jumped: ${text}`];
}

/** Waits until changes are visible. @param {Page} page */
const painted = (page) =>
  page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(0)))));

/**
 * Sets another language or theme without reloading, as the page of settings does, and another size
 * of the window.
 * @param {import("./harness.js").World} world
 * @param {{ language?: string, theme?: string }} settings @param {{ width: number, height: number }} [size]
 */
export async function show({ page, loaded }, settings, size) {
  if (size) await page.setViewportSize(size);
  await page.evaluate(async (settings) => {
    const main = /** @type {HTMLScriptElement} */ (document.querySelector('script[type="module"]'));
    const signals = await import(new URL("settings.js", main.src).href);
    for (const [name, value] of Object.entries(settings)) signals[name].value = value;
  }, settings);
  await painted(page);
  await loaded();
}

/** Returns an error if the page is wider than its window. @param {Page} page */
export async function wide(page) {
  const [scrollWidth = 0, clientWidth = 0] = await page.evaluate(() => {
    const { scrollWidth, clientWidth } = document.documentElement;
    return [scrollWidth, clientWidth];
  });
  return scrollWidth <= clientWidth ? [] : [`${scrollWidth} px wide in ${clientWidth}`];
}

const PRESSED =
  "a[href], button, input, select, textarea, summary, label.checkbox, label.button, [role=slider], [role=application]";

/** Returns controls that are smaller than 44 px on a tablet, and the number of controls. @param {Page} page */
export function pressed(page) {
  return page.evaluate((pressed) => {
    // a box is pressed at its label; parts hidden until the keyboard reaches them are not pressed
    const exempt = "input[type=checkbox], input[type=radio], .visually-hidden, .skip, [aria-hidden=true] *";
    const inSentence = (/** @type {Element} */ one) => {
      const sentence = one.closest("p, li, dd");
      const more = sentence?.textContent?.trim() !== one.textContent?.trim();
      return one.tagName === "A" && getComputedStyle(one).display === "inline" && sentence !== null && more;
    };
    const all = [...document.querySelectorAll(pressed)].filter(
      (one) => one.checkVisibility() && !one.matches(exempt) && !inSentence(one),
    );
    const small = all.flatMap((one) => {
      const { width, height } = one.getBoundingClientRect();
      if (Math.min(width, height) >= 43.5) return [];
      return [`${one.tagName} ${one.getAttribute("class")} ${one.textContent} ${width} × ${height}`];
    });
    return { small: [...new Set(small)], count: all.length };
  }, PRESSED);
}

/** The unit after a number, whatever space separates them. */
const UNITS = /(?<=[\d⁰¹²³⁴-⁹]\s)[mµ]m(\/mm[²³⁴-⁹]?)?(?![\p{L}/])/gu;

/** Returns texts in the pseudo-language that are not from the tables. @param {Page} page @returns {Promise<string[]>} */
export function strays(page) {
  return page.evaluate((units) => {
    // texts within texts are marked twice; units are the same in every language
    /** @type {(text: string) => string} */
    const bare = (text) => {
      const less = text.replaceAll(/⟦[^⟦⟧]*⟧/gu, "");
      return less === text ? less.replaceAll(units, "") : bare(less);
    };
    const marked = (/** @type {string} */ text) => !/\p{L}/u.test(bare(text));
    /** @type {string[]} */
    const found = [];
    const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
    for (let node = walker.nextNode(); node; node = walker.nextNode()) {
      const parent = node.parentElement;
      if (!parent || parent.closest("[translate=no], [lang], script, noscript, style")) {
        if (parent?.closest("[lang]") !== document.documentElement) continue;
      }
      if (parent?.closest("[translate=no], script, noscript, style")) continue;
      // an option holds text alone: the interface's name for it is in brackets
      const text = (node.textContent ?? "").replace(parent?.tagName === "OPTION" ? / \([a-z_]+\)$/ : "", "");
      if (!marked(text)) found.push(`${parent?.tagName}: ${node.textContent}`);
    }
    for (const one of document.querySelectorAll("[aria-label], [title], [placeholder], [aria-valuetext]")) {
      if (one.closest("[translate=no]")) continue;
      for (const name of ["aria-label", "title", "placeholder"]) {
        const text = one.getAttribute(name);
        if (text && !marked(text) && text !== "flankfit") found.push(`${one.tagName} ${name}: ${text}`);
      }
    }
    return found;
  }, UNITS);
}
