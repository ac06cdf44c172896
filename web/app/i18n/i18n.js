// Texts of the language that is chosen. Each page has its tables, `i18n/en/<page>.js` and
// `i18n/de/<page>.js`, whose keys are the same by type:
//
//     const t = texts({ en, de });
//     html`<p>${t.jobsFound(3)}</p>`
//
// A text is a string, or a function of its numbers and names. Reading one within a component
// subscribes the component to the language.

import { computed } from "../../vendor/ui.js";
import { formats } from "../lib/format.js";
import { shownLanguage as language } from "../settings.js";

/** @typedef {Record<string, string | ((...values: never[]) => string)>} Table */
/**
 * The same keys in another language.
 * @template {Table} T
 * @typedef {{ [Key in keyof T]: T[Key] extends string ? string : T[Key] }} Same
 */

/**
 * @template {Table} T
 * @param {{ en: T, de: Same<T> }} tables
 * @returns {T}
 */
export function texts(tables) {
  return new Proxy(tables.en, {
    get(_, key) {
      const table = language.value === "de" ? tables.de : tables.en;
      const text = table[/** @type {keyof T} */ (key)];
      if (language.value !== "pseudo") return text;
      return typeof text === "function"
        ? (/** @type {never[]} */ ...values) => marked(text(...values))
        : marked(String(text));
    },
  });
}

/** @param {string} text */
const marked = (text) => `⟦${text}⟧`;

/** Numbers and times of the chosen language: `fmt.value.withError(…)`. */
export const fmt = computed(() => formats(language.value === "de" ? "de" : "en"));
