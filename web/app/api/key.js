// The API key of this browser: in sessionStorage, in localStorage when asked for, never in a URL.

import { signal } from "../../vendor/ui.js";

const PLACE = "flankfit.key";

/** Grows with every new key or connection: whoever shows data asks for it again. */
export const session = signal(0);

/** What the server wanted a key for, while the dialog asks for one. @type {import("../../vendor/ui.js").Signal<"unauthorized" | "forbidden" | null>} */
export const keyWanted = signal(/** @type {"unauthorized" | "forbidden" | null} */ (null));

/** @returns {string | null} */
export function currentKey() {
  return sessionStorage.getItem(PLACE) ?? localStorage.getItem(PLACE);
}

/** Whether the key outlives the tab. */
export function isRemembered() {
  return localStorage.getItem(PLACE) !== null;
}

/** @param {string} key @param {boolean} remember */
export function takeKey(key, remember) {
  forgetKey();
  (remember ? localStorage : sessionStorage).setItem(PLACE, key);
  keyWanted.value = null;
  session.value += 1;
}

export function forgetKey() {
  sessionStorage.removeItem(PLACE);
  localStorage.removeItem(PLACE);
  session.value += 1;
}
