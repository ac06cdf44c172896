// Form input, kept while the tab lives: leaving and returning, or a reload, loses none of it.

import { useState } from "../../vendor/ui.js";

/**
 * Returns a value kept in this tab under a name, until it has been sent and is forgotten.
 * @template Value
 * @param {string} name @param {() => Value} begin what it is before anything was typed
 * @param {boolean} [lasting] kept in this browser, not only in the tab
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
      // a full store loses only persistence over reloads
    }
  };
  const forget = () => {
    setValue(begin());
    try {
      store().removeItem(place);
    } catch {
      // no stored draft
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
