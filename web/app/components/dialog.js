// A dialog over the page: the browser's own, which keeps the focus within and gives it back.

import { t } from "../i18n/common.js";
import { h, html, signal, useEffect, useId, useRef } from "../../vendor/ui.js";
import { PutOff } from "./put_off.js";

/** @typedef {import("../../vendor/ui.js").ComponentChildren} Children */

/** How many are open: what stands outside of them cannot be reached. */
export const openDialogs = signal(0);

/**
 * Shown as long as it is rendered; Escape and the cross ask to close it.
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
