// Turns a stream into an iteration of its job.

import { useAttempt } from "../api/attempt.js";
import { answer, api } from "../api/client.js";
import { t as common } from "../i18n/common.js";
import de from "../i18n/de/stream.js";
import en from "../i18n/en/stream.js";
import { texts } from "../i18n/i18n.js";
import { useDraft } from "../lib/draft.js";
import { useLeaving } from "../lib/leaving.js";
import { h, html, useState } from "../../vendor/ui.js";
import { Dialog } from "./dialog.js";
import { TextField } from "./form.js";
import { Failure } from "./states.js";
import { notify } from "./toast.js";

const t = texts({ en, de });
const FIELDS = /** @type {const} */ (["instrument", "operator", "note"]);

/** @param {{ streamId: string, onDone: (iteration: number) => void, onClose: () => void }} props */
export function FinishStream({ streamId, onDone, onClose }) {
  const [typed, setTyped, forget] = useDraft(`finish ${streamId}`, () => ({ instrument: "", operator: "", note: "" }));
  const [error, setError] = useState(/** @type {unknown} */ (undefined));
  const [sending, setSending] = useState(false);
  const attempt = useAttempt(`finish ${streamId}`);
  const leaving = useLeaving();
  const submit = async (/** @type {Event} */ event) => {
    event.preventDefault();
    if (sending) return;
    setSending(true);
    setError(undefined);
    /** @type {import("../api/client.js").Schema<"StreamFinish">} */
    const body = {};
    for (const name of FIELDS) if (typed[name].trim() !== "") body[name] = typed[name].trim();
    try {
      const header = attempt.headers(body);
      const params = { path: { stream_id: streamId }, header };
      const { data } = await answer(api.POST("/v1/streams/{stream_id}/finish", { signal: leaving, params, body }));
      attempt.done();
      forget();
      onDone(data.number);
    } catch (failed) {
      if (leaving.aborted) return notify(common.cancelled, "news");
      setError(failed);
      setSending(false);
    }
  };
  return h(Dialog, {
    title: t.finish,
    onClose,
    children: html`<form onSubmit=${submit}>
      <p>${t.finishText}</p>
      ${FIELDS.map((name) =>
        h(TextField, {
          key: name,
          label: t[name],
          value: typed[name],
          onInput: (value) => setTyped({ ...typed, [name]: value }),
          error,
          pointer: `/${name}`,
          ...(name === "note" ? { lines: 2 } : { maxLength: 200 }),
        }),
      )}
      ${error !== undefined && h(Failure, { error, except: FIELDS.map((name) => `/${name}`) })}
      <div class="actions end">
        <button type="button" class="button" onClick=${onClose}>${common.cancel}</button>
        <button type="submit" class="button primary" disabled=${sending}>${t.finishNow}</button>
      </div>
    </form>`,
  });
}
