// The frame of every page: header, navigation, messages, dialogs.

import { answer, api } from "../api/client.js";
import { lostAt, probe } from "../api/connection.js";
import { may, setCaller } from "../api/key.js";
import { underway, useResource } from "../api/resource.js";
import { current } from "../navigation.js";
import { fmt } from "../i18n/i18n.js";
import { t } from "../i18n/common.js";
import { hrefIf } from "../router.js";
import { h, html, signal, useEffect } from "../../vendor/ui.js";
import { openDialogs } from "./dialog.js";
import { KeyDialog } from "./key_dialog.js";
import { PutOff } from "./put_off.js";
import { ShortcutHelp } from "./shortcuts.js";
import { Toasts } from "./toast.js";

/** Set if the server has other files by now. */
export const outdated = signal(false);
/** Set while the module of a page is loading. */
export const arriving = signal(false);

/** @param {{ children: import("../../vendor/ui.js").ComponentChildren }} props */
export function Frame({ children }) {
  const busy = underway.value > 0 || arriving.value;
  const who = useResource("whoami", (signal) => answer(api.GET("/v1/whoami", { signal })));
  useEffect(() => {
    if (who.data) setCaller(who.data);
  }, [who.data]);
  return html`
    <a class="skip" href="#content">${t.skip}</a>
    <header class="top">
      <a class="brand" href="/jobs" aria-label="flankfit">
        <svg viewBox="0 0 32 32" width="24" height="24" aria-hidden="true">
          <path class="tooth" d="M5 26C11 24 11 6 16 6s5 18 11 20" /><path class="root" d="M5 26h22" />
        </svg>
        <span translate="no">flankfit</span>
      </a>
      <nav aria-label=${t.mainNavigation}>
        <ul>${h(MainLink, { path: "/jobs", label: t.jobs })}${may("compute") && h(MainLink, { path: "/fit", label: t.fit })}
          ${h(MainLink, { path: "/settings", label: t.settings })}</ul>
      </nav>
    </header>
    ${h(Notices, null)}${h(Toasts, null)}
    <main id="content" tabindex="-1" aria-busy=${busy ? "true" : "false"}>${children}</main>
    ${h(KeyDialog, null)}${h(ShortcutHelp, null)}
  `;
}

/** A link of the header; a page that does not exist yet has none. @param {{ path: string, label: string }} props */
function MainLink({ path, label }) {
  const to = hrefIf(path);
  if (!to) return null;
  const here = current.value?.page.path ?? "";
  const within = here === path || here.startsWith(`${path}/`);
  return html`<li><a href=${to} aria-current=${here === path ? "page" : within ? "true" : undefined}>${label}</a></li>`;
}

function Notices() {
  const lost = lostAt.value;
  return html`<div class="notices" role="status" aria-live="polite">
    ${
      lost &&
      html`<p class="notice warn">
        <strong>${t.noAnswer}.</strong> ${t.notLive(fmt.value.clock(lost))}
        <button type="button" class="button small" onClick=${probe}>${t.askNow}</button>
      </p>`
    }
    ${openDialogs.value === 0 && h(PutOff, null)}
    ${
      outdated.value &&
      html`<p class="notice">
        ${t.newVersion}
        <button type="button" class="button small" onClick=${() => location.reload()}>${t.reload}</button>
      </p>`
    }
  </div>`;
}
