// Settings of this browser: language, theme, shortcuts. Kept in localStorage.

import { computed, effect, signal } from "../vendor/ui.js";

/** @typedef {"en" | "de" | "pseudo"} Language `pseudo` marks every text of the tables, for tests */
/** @typedef {"system" | "light" | "dark"} Theme */

const PLACE = "flankfit.settings";
const kept = read();

/** @type {import("../vendor/ui.js").Signal<Language>} */
export const language = signal(oneOf(kept["language"], ["en", "de", "pseudo"]) ?? ofBrowser());
/** The language of a page whose address names one, whatever was chosen: a report goes to others. @type {import("../vendor/ui.js").Signal<Language | undefined>} */
export const languageOfPage = signal(undefined);
/** The displayed language. */
export const shownLanguage = computed(() => languageOfPage.value ?? language.value);
/** @type {import("../vendor/ui.js").Signal<Theme>} */
export const theme = signal(oneOf(kept["theme"], ["system", "light", "dark"]) ?? "system");
export const shortcuts = signal(kept["shortcuts"] !== false);
/** Set if the list of jobs has one line per job. */
export const compact = signal(kept["compact"] === true);
/** Columns hidden in the list of jobs, by their keys. */
export const hidden = signal(Array.isArray(kept["hidden"]) ? kept["hidden"].map(String) : []);

effect(() => {
  const root = document.documentElement;
  root.lang = shownLanguage.value === "pseudo" ? "en" : shownLanguage.value;
  if (theme.value === "system") delete root.dataset["theme"];
  else root.dataset["theme"] = theme.value;
});

/** Stores the settings from now on. */
export function keep() {
  effect(() => {
    const settings = {
      language: language.value,
      theme: theme.value,
      shortcuts: shortcuts.value,
      compact: compact.value,
      hidden: hidden.value,
    };
    try {
      localStorage.setItem(PLACE, JSON.stringify(settings));
    } catch {
      // without storage a choice lasts until the browser is closed
    }
  });
}

/** @returns {Record<string, unknown>} */
function read() {
  try {
    const value = JSON.parse(localStorage.getItem(PLACE) ?? "{}");
    return typeof value === "object" && value !== null ? value : {};
  } catch {
    return {};
  }
}

/** @template {string} T @param {unknown} value @param {readonly T[]} known @returns {T | undefined} */
function oneOf(value, known) {
  return known.find((one) => one === value);
}

/** @returns {Language} */
function ofBrowser() {
  return navigator.language.startsWith("de") ? "de" : "en";
}
