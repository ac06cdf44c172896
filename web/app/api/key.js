// The API key of this browser: in sessionStorage, on request in localStorage, never in a URL.

import { signal } from "../../vendor/ui.js";

const PLACE = "flankfit.key";
const MAY = "flankfit.may";

/** Grows with every new key or connection, upon which data is loaded again. */
export const session = signal(0);

/** The reason for which the server requires a key, while the dialog is open. @type {import("../../vendor/ui.js").Signal<"unauthorized" | "forbidden" | null>} */
export const keyWanted = signal(/** @type {"unauthorized" | "forbidden" | null} */ (null));

/** @typedef {import("./client.js").Schema<"Whoami">} Whoami */
/** The caller, as the server said last. @type {import("../../vendor/ui.js").Signal<Whoami | undefined>} */
export const caller = signal(storedCaller());

/** Returns true if the caller has this scope, or if their scopes are not known yet. @param {Whoami["scopes"][number]} scope */
export function may(scope) {
  return caller.value?.scopes.includes(scope) ?? true;
}

/** @param {Whoami | undefined} who */
export function setCaller(who) {
  if (JSON.stringify(who) === JSON.stringify(caller.peek())) return;
  caller.value = who;
  if (who) sessionStorage.setItem(MAY, JSON.stringify(who));
  else sessionStorage.removeItem(MAY);
}

/** Returns the caller stored in this tab, so that a reload offers the same actions at once. @returns {Whoami | undefined} */
function storedCaller() {
  try {
    return JSON.parse(globalThis.sessionStorage?.getItem(MAY) ?? "null") ?? undefined;
  } catch {
    return undefined;
  }
}

/** @returns {string | null} */
export function currentKey() {
  return sessionStorage.getItem(PLACE) ?? localStorage.getItem(PLACE);
}

/** Returns true if the key outlives the tab. */
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
  setCaller(undefined);
  session.value += 1;
}
