// Whether the server answers. While it does not, it is asked again after 1 … 30 s; data that is
// shown stays.

import { signal } from "../../vendor/ui.js";
import { session } from "./key.js";

/** Since when the server has not answered. @type {import("../../vendor/ui.js").Signal<Date | null>} */
export const lostAt = signal(/** @type {Date | null} */ (null));

const LONGEST = 30_000;
let wait = 1000;
/** @type {ReturnType<typeof setTimeout> | undefined} */
let timer;

export function connected() {
  if (lostAt.peek() === null) return;
  lostAt.value = null;
  wait = 1000;
  clearTimeout(timer);
  // what could not be loaded is asked for again
  session.value += 1;
}

export function disconnected() {
  if (lostAt.peek() === null) {
    lostAt.value = new Date();
    schedule();
  }
}

/** Asks whether the server is there. */
export async function probe() {
  clearTimeout(timer);
  try {
    await fetch("/healthz", { cache: "no-store" });
    connected();
    return true;
  } catch {
    lostAt.value ??= new Date();
    wait = Math.min(2 * wait, LONGEST);
    schedule();
    return false;
  }
}

function schedule() {
  clearTimeout(timer);
  timer = setTimeout(probe, wait);
}

globalThis.addEventListener?.("online", () => {
  if (lostAt.peek() !== null) probe();
});
