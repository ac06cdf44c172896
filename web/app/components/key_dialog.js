// Requests an API key when the server requires one, or another one.

import { currentKey, forgetKey, isRemembered, keyWanted, takeKey } from "../api/key.js";
import { forgetResources } from "../api/resource.js";
import { t } from "../i18n/common.js";
import { h, html, useState } from "../../vendor/ui.js";
import { Dialog } from "./dialog.js";
import { Checkbox, TextField } from "./form.js";

export function KeyDialog() {
  return keyWanted.value === null ? null : h(KeyForm, { wanted: keyWanted.value });
}

/** @param {{ wanted: "unauthorized" | "forbidden" }} props */
function KeyForm({ wanted }) {
  const [key, setKey] = useState("");
  const [remember, setRemember] = useState(isRemembered());
  const close = () => {
    keyWanted.value = null;
  };
  const submit = (/** @type {Event} */ event) => {
    event.preventDefault();
    if (key.trim() === "") return;
    forgetResources();
    takeKey(key.trim(), remember);
  };
  const forget = () => {
    forgetResources();
    forgetKey();
    close();
  };
  return h(Dialog, {
    title: t.keyTitle,
    onClose: close,
    children: html`<form onSubmit=${submit} novalidate>
      <p>${wanted === "forbidden" ? t.keyForbidden : t.keyText}</p>
      ${h(TextField, { label: t.key, value: key, onInput: setKey, type: "password", required: true })}
      ${h(Checkbox, { label: t.rememberKey, checked: remember, onChange: setRemember })}
      <div class="actions">
        <button type="submit" class="button primary">${t.useKey}</button>
        <button type="button" class="button" onClick=${close}>${t.cancel}</button>
        ${currentKey() && html`<button type="button" class="button" onClick=${forget}>${t.forgetKey}</button>`}
      </div>
    </form>`,
  });
}
