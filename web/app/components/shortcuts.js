// Keyboard shortcuts: single keys, which can be turned off (WCAG 2.1.4), and their list.

import { t } from "../i18n/common.js";
import { shortcuts } from "../settings.js";
import { h, html, signal, useEffect } from "../../vendor/ui.js";
import { Dialog } from "./dialog.js";

/** @type {Map<string, { label: () => string, act: () => void }>} */
const known = new Map();
const listed = signal(false);

/**
 * Registers a key of the page that is shown.
 * @param {string} key as `KeyboardEvent.key` has it
 * @param {() => string} label what it does, in the language of the moment
 * @param {() => void} act
 */
export function useShortcut(key, label, act) {
  useEffect(() => {
    const entry = { label, act };
    known.set(key, entry);
    return () => {
      if (known.get(key) === entry) known.delete(key);
    };
  });
}

export function listenForShortcuts() {
  addEventListener("keydown", (event) => {
    if (!shortcuts.value || event.defaultPrevented || event.ctrlKey || event.metaKey || event.altKey) return;
    const target = event.target instanceof HTMLElement ? event.target : null;
    if (target?.closest("input, textarea, select, [contenteditable], dialog")) return;
    const entry = known.get(event.key);
    if (!entry) return;
    event.preventDefault();
    entry.act();
  });
}

export function ShortcutHelp() {
  useShortcut(
    "?",
    () => t.shortcutHelp,
    () => {
      listed.value = true;
    },
  );
  const close = () => {
    listed.value = false;
  };
  if (!listed.value) return null;
  return h(Dialog, {
    title: t.shortcuts,
    onClose: close,
    children: html`<dl class="shortcuts">
        ${[...known].map(([key, { label }]) => html`<div key=${key}><dt><kbd translate="no">${key}</kbd></dt><dd>${label()}</dd></div>`)}
      </dl>
      <p class="quiet">${t.shortcutsOff}</p>`,
  });
}
