// Requests a reason, sends, and shows errors. The input stays until it has been sent.

import { ApiError } from "../api/problem.js";
import { t as common } from "../i18n/common.js";
import { useDraft } from "../lib/draft.js";
import { h, html, useState } from "../../vendor/ui.js";
import { Dialog } from "./dialog.js";
import { TextField } from "./form.js";
import { Failure } from "./states.js";
import { Progress } from "./progress.js";
import { announce, notify } from "./toast.js";
import { stopNote } from "./underway.js";

/** @typedef {import("../../vendor/ui.js").ComponentChildren} Children */

/**
 * @param {{
 *   title: string, text?: string, label: string, action: string, required?: boolean, draft: string,
 *   watched?: import("../api/watched.js").Watched | undefined, versions?: () => Children, send: (reason: string) => Promise<void>, onClose: () => void,
 * }} props `draft`: under which name the reason is kept; `versions`: both, where somebody else was first; sending once
 *   more is then meant all the same; `watched`: what takes long, which cancelling stops; `send` is done when it has been stored
 */
export function ReasonDialog({
  title,
  text,
  label,
  action,
  required = false,
  draft,
  watched,
  versions,
  send,
  onClose,
}) {
  const [reason, setReason, forget] = useDraft(draft, () => "");
  const [error, setError] = useState(/** @type {unknown} */ (undefined));
  const [sending, setSending] = useState(false);
  const overtaken = versions && error instanceof ApiError && error.status === 412;
  const submit = async (/** @type {Event} */ event) => {
    event.preventDefault();
    if (sending || (required && reason.trim() === "")) return;
    setSending(true);
    if (!overtaken) setError(undefined);
    try {
      await send(reason.trim());
      forget();
      onClose();
    } catch (failed) {
      setSending(false);
      const stopped = stopNote(failed);
      setError(stopped ? undefined : failed);
      if (stopped) notify(stopped, "news");
      if (failed instanceof ApiError && failed.status === 412) announce(common.changedMeanwhile);
    }
  };
  const close = watched?.running ? watched.stop : onClose;
  return h(Dialog, {
    title,
    onClose: close,
    children: html`<form onSubmit=${submit}>
      ${text && html`<p>${text}</p>`}
      ${overtaken && html`<div class="failure" role="alert"><h3>${common.changedMeanwhile}</h3>${versions()}</div>`}
      ${h(TextField, { label, value: reason, onInput: setReason, lines: 3, maxLength: 4000, required, error, pointer: "/reason" })}
      ${error !== undefined && !overtaken && h(Failure, { error, except: ["/reason"] })}
      ${watched?.running && h(Progress, { label: action, progress: watched.progress })}
      <div class="actions end">
        <button type="button" class="button" onClick=${close}>${common.cancel}</button>
        <button type="submit" class="button primary" disabled=${sending || (required && reason.trim() === "")}>${overtaken ? common.allTheSame(action) : action}</button>
      </div>
    </form>`,
  });
}
