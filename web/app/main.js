// The entry point of the dashboard: settings, the page of the address, the frame around it.

import { probe } from "./api/connection.js";
import { session } from "./api/key.js";
import { OfflineError } from "./api/problem.js";
import { arriving, Frame, outdated } from "./components/frame.js";
import { NoSuchPage } from "./components/page.js";
import { listenForShortcuts } from "./components/shortcuts.js";
import { Failure } from "./components/states.js";
import { current, follow, pathname } from "./navigation.js";
import { load } from "./router.js";
import { keep } from "./settings.js";
import { h, render, useErrorBoundary, useLayoutEffect, useState } from "../vendor/ui.js";

/** @typedef {import("./router.js").PageComponent} PageComponent */
/** @typedef {{ path: string, component: PageComponent | null, params: Record<string, string>, error?: unknown }} Shown */

function App() {
  const [shown, setShown] = useState(/** @type {Shown | null} */ (null));
  const target = current.value;
  const place = pathname.value;
  // a page that could not be loaded is loaded again with the rest
  const again = shown?.error === undefined ? 0 : session.value;
  // before the browser paints: the address changes only with a page on its way
  useLayoutEffect(() => {
    let wanted = true;
    const show = (/** @type {Shown} */ next) => {
      if (!wanted) return;
      arriving.value = false;
      setShown(next);
    };
    if (!target) {
      show({ path: place, component: null, params: {} });
      return undefined;
    }
    arriving.value = true;
    arrive(target.page).then(
      (component) => show({ path: place, component, params: target.params }),
      async (/** @type {unknown} */ error) => {
        const responds = await probe();
        // a response without the file of this version means a newer version
        if (responds) outdated.value = true;
        show({ path: place, component: null, params: {}, error: responds ? error : new OfflineError("no answer") });
      },
    );
    return () => {
      wanted = false;
    };
  }, [place, again]);
  return h(Frame, { children: shown && h(Shown, { key: shown.path, shown }) });
}

/** @param {{ shown: Shown }} props */
function Shown({ shown }) {
  const [broken, reset] = useErrorBoundary();
  if (broken !== undefined || shown.error !== undefined) {
    return h(Failure, { error: broken ?? shown.error, retry: broken === undefined ? () => location.reload() : reset });
  }
  return shown.component ? h(shown.component, { params: shown.params }) : h(NoSuchPage, null);
}

/** Loads a page with its styles. @param {NonNullable<typeof current.value>["page"]} page */
async function arrive(page) {
  const { default: component, styles = [] } = await load(page);
  await Promise.all(styles.map(loadStyle));
  return component;
}

/** @param {string} name of a file in `styles/pages/` @returns {Promise<void>} */
function loadStyle(name) {
  const url = new URL(`./styles/pages/${name}.css`, import.meta.url).href;
  if ([...document.styleSheets].some((sheet) => sheet.href === url)) return Promise.resolve();
  return new Promise((resolve, reject) => {
    const link = document.createElement("link");
    link.rel = "stylesheet";
    link.href = url;
    link.onload = () => resolve();
    link.onerror = () => reject(new Error(`no style ${name}`));
    document.head.append(link);
  });
}

keep();
follow();
listenForShortcuts();
const root = document.getElementById("app");
if (root) render(h(App, null), root);
