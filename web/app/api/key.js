// The API key of this browser: in sessionStorage, in localStorage when asked for, never in a URL.

import { signal } from "../../vendor/ui.js";

const PLACE = "flankfit.key";
const MAY = "flankfit.may";

/** Grows with every new key or connection: whoever shows data asks for it again. */
export const session = signal(0);

/** What the server wanted a key for, while the dialog asks for one. @type {import("../../vendor/ui.js").Signal<"unauthorized" | "forbidden" | null>} */
export const keyWanted = signal(/** @type {"unauthorized" | "forbidden" | null} */ (null));

/** @typedef {import("./client.js").Schema<"Whoami">} Whoami */
/** Who asks, as the server said last. @type {import("../../vendor/ui.js").Signal<Whoami | undefined>} */
export const caller = signal(storedCaller());

/** Whether the caller may ask for what needs this scope; as long as nobody has said, they may try. @param {Whoami["scopes"][number]} scope */
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

/** From this tab, so that a reload offers at once what it offered before. @returns {Whoami | undefined} */
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
  setCaller(undefined);
  session.value += 1;
}
