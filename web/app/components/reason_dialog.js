// Asks for a reason, sends, and shows what is wrong.

import { t as common } from "../i18n/common.js";
import { h, html, useState } from "../../vendor/ui.js";
import { Dialog } from "./dialog.js";
import { TextField } from "./form.js";
import { Failure } from "./states.js";

/**
 * @param {{
 *   title: string, text?: string, label: string, action: string, required?: boolean,
 *   send: (reason: string) => Promise<void>, onClose: () => void,
 * }} props `send` is done when it has been stored
 */
export function ReasonDialog({ title, text, label, action, required = false, send, onClose }) {
  const [reason, setReason] = useState("");
  const [error, setError] = useState(/** @type {unknown} */ (undefined));
  const [sending, setSending] = useState(false);
  const submit = async (/** @type {Event} */ event) => {
    event.preventDefault();
    if (sending || (required && reason.trim() === "")) return;
    setSending(true);
    try {
      await send(reason.trim());
      onClose();
    } catch (failed) {
      setError(failed);
      setSending(false);
    }
  };
  return h(Dialog, {
    title,
    onClose,
    children: html`<form onSubmit=${submit}>
      ${text && html`<p>${text}</p>`}
      ${h(TextField, { label, value: reason, onInput: setReason, lines: 3, maxLength: 4000, required, error, pointer: "/reason" })}
      ${error !== undefined && h(Failure, { error, except: ["/reason"] })}
      <div class="actions end">
        <button type="button" class="button" onClick=${onClose}>${common.cancel}</button>
        <button type="submit" class="button primary" disabled=${sending || (required && reason.trim() === "")}>${action}</button>
      </div>
    </form>`,
  });
}
