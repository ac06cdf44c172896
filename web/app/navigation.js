// The location of the browser: the path, and in the query the whole view (layer, filter, camera),
// so that back, reload and sharing restore it.

import { computed, signal } from "../vendor/ui.js";
import { match } from "./router.js";

const address = signal(here());

function here() {
  return { pathname: location.pathname, search: location.search };
}

/** The current page with its parameters; undefined if the path names none. */
export const current = computed(() => match(address.value.pathname));
export const pathname = computed(() => address.value.pathname);
/** The query of the address. */
export const query = computed(() => new URLSearchParams(address.value.search));

/** Goes to another address of the dashboard. @param {string} to @param {{ replace?: boolean }} [options] */
export function navigate(to, { replace = false } = {}) {
  if (to === location.pathname + location.search) return;
  if (replace) history.replaceState(history.state, "", to);
  else history.pushState({}, "", to);
  address.value = here();
}

/**
 * Changes parts of the query and leaves the rest. By default this adds no step to the browser's
 * history; steps that a user would want to undo set `step`.
 * @param {Record<string, string | number | undefined>} changes undefined takes a part away
 * @param {{ step?: boolean }} [options]
 */
export function setQuery(changes, { step = false } = {}) {
  const search = new URLSearchParams(location.search);
  for (const [name, value] of Object.entries(changes)) {
    if (value === undefined || value === "") search.delete(name);
    else search.set(name, String(value));
  }
  navigate(search.size > 0 ? `${location.pathname}?${search}` : location.pathname, { replace: !step });
}

/** Follows back and forward, and links to pages without reloading anything. */
export function follow() {
  if (location.pathname === "/") navigate("/jobs", { replace: true });
  addEventListener("popstate", () => {
    address.value = here();
  });
  document.addEventListener("click", (event) => {
    if (
      event.defaultPrevented ||
      event.button !== 0 ||
      event.metaKey ||
      event.ctrlKey ||
      event.shiftKey ||
      event.altKey
    )
      return;
    const link = event.target instanceof Element ? event.target.closest("a") : null;
    if (!link?.href || link.target || link.hasAttribute("download")) return;
    const url = new URL(link.href);
    if (url.origin !== location.origin || !match(url.pathname)) return;
    if (url.hash && url.pathname === location.pathname && url.search === location.search) return;
    event.preventDefault();
    navigate(url.pathname + url.search);
    scrollTo(0, 0);
  });
}
