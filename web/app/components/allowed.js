// Actions that a role lacks permission for are hidden; a page that needs one says so.

import { caller, currentKey, keyWanted, may } from "../api/key.js";
import { t } from "../i18n/common.js";
import { h, html } from "../../vendor/ui.js";
import { Empty } from "./states.js";

/** @typedef {import("../../vendor/ui.js").ComponentChildren} Children */
/** @typedef {"compute" | "measure" | "decide"} Scope */

/**
 * The children, or the reason for their absence.
 * @param {{ scope: Scope, children: () => Children, short?: boolean }} props `short`: a line instead of a block
 */
export function Allowed({ scope, children, short = false }) {
  if (may(scope)) return children();
  const why = t.mayNot(t[`may_${scope}`], caller.value?.role ?? "");
  if (short) return html`<p class="quiet">${why}</p>`;
  const onClick = () => {
    keyWanted.value = "forbidden";
  };
  const action = currentKey() ? { label: t.anotherKey, onClick } : undefined;
  return h(Empty, { children: why, action });
}
