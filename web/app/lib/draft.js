// What was typed into a form, kept while the tab lives: going away and back, or a reload, loses none of it.

import { useState } from "../../vendor/ui.js";

/**
 * A value that is kept in this tab under a name, until it has been sent and is forgotten.
 * @template Value
 * @param {string} name @param {() => Value} begin what it is before anything was typed
 * @param {boolean} [lasting] kept in this browser, beyond the tab
 * @returns {[Value, (value: Value) => void, () => void]}
 */
export function useDraft(name, begin, lasting = false) {
  const place = `flankfit.draft ${name}`;
  const store = () => (lasting ? localStorage : sessionStorage);
  const [value, setValue] = useState(() => /** @type {Value} */ (kept(store, place) ?? begin()));
  /** @param {Value} next */
  const take = (next) => {
    setValue(next);
    try {
      store().setItem(place, JSON.stringify(next));
    } catch {
      // a full store loses only what outlives the page
    }
  };
  const forget = () => {
    setValue(begin());
    try {
      store().removeItem(place);
    } catch {
      // nothing was kept
    }
  };
  return [value, take, forget];
}

/** @param {() => Storage} store @param {string} place */
function kept(store, place) {
  try {
    return JSON.parse(store().getItem(place) ?? "null") ?? undefined;
  } catch {
    return undefined;
  }
}
