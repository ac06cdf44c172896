// Dialogs over the page, which are the browser's own, keep the focus and return it; and menus.

import { t } from "../i18n/common.js";
import { h, html, signal, useEffect, useId, useRef, useState } from "../../vendor/ui.js";
import { PutOff } from "./put_off.js";

/** @typedef {import("../../vendor/ui.js").ComponentChildren} Children */

/** The number of open dialogs: content outside of them cannot be reached. */
export const openDialogs = signal(0);

/**
 * A dialog, shown as long as it is rendered; Escape and the cross request its end.
 * @param {{ title: Children, onClose: () => void, children: Children, wide?: boolean }} props
 */
export function Dialog({ title, onClose, children, wide = false }) {
  const id = useId();
  const dialog = useRef(/** @type {HTMLDialogElement | null} */ (null));
  useEffect(() => {
    const element = dialog.current;
    const before = document.activeElement;
    element?.showModal();
    openDialogs.value += 1;
    return () => {
      openDialogs.value -= 1;
      element?.close();
      if (before instanceof HTMLElement) before.focus();
    };
  }, []);
  const cancel = (/** @type {Event} */ event) => {
    event.preventDefault();
    onClose();
  };
  return html`<dialog ref=${dialog} class=${wide ? "wide" : ""} aria-labelledby=${id} onCancel=${cancel}>
    <header>
      <h2 id=${id}>${title}</h2>
      <button type="button" class="icon-button" aria-label=${t.close} onClick=${onClose}>
        <svg viewBox="0 0 16 16" width="16" height="16" aria-hidden="true"><path d="M3 3l10 10M13 3L3 13" /></svg>
      </button>
    </header>
    <div role="status" aria-live="polite">${h(PutOff, null)}</div>
    <div class="dialog-body">${children}</div>
  </dialog>`;
}

/**
 * A menu below its button. A press elsewhere, on one of its buttons or on Escape closes it, and so
 * does losing the focus.
 * @param {{ label: string, children: Children }} props
 */
export function Menu({ label, children }) {
  const menu = useRef(/** @type {HTMLDetailsElement | null} */ (null));
  const [open, setOpen] = useState(false);
  const close = () => menu.current?.removeAttribute("open");
  useEffect(() => {
    const elsewhere = (/** @type {PointerEvent} */ event) => {
      if (event.target instanceof Node && !menu.current?.contains(event.target)) close();
    };
    document.addEventListener("pointerdown", elsewhere);
    return () => document.removeEventListener("pointerdown", elsewhere);
  }, []);
  const back = () => {
    close();
    menu.current?.querySelector("summary")?.focus();
  };
  const press = (/** @type {KeyboardEvent} */ event) => {
    if (event.key !== "Escape" || !menu.current?.open) return;
    event.stopPropagation();
    back();
  };
  const choose = (/** @type {MouseEvent} */ event) => {
    if (event.target instanceof Element && event.target.closest("button")) back();
  };
  const leave = (/** @type {FocusEvent} */ event) => {
    const to = event.relatedTarget;
    // a press on a label within focuses `main` around it
    if (to instanceof Node && !menu.current?.contains(to) && !to.contains(menu.current)) close();
  };
  return html`<details class="menu" ref=${menu} onKeyDown=${press} onFocusOut=${leave} onToggle=${() => setOpen(menu.current?.open === true)}>
    <summary class="button">${label}</summary>
    ${open && html`<div class="menu-items" onClick=${choose}>${children}</div>`}
  </details>`;
}
