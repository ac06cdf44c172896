// Requests that wait to be sent again, with the way to stop them: above the page, or within the
// dialog that is open over it.

import { putOff } from "../api/connection.js";
import { t } from "../i18n/common.js";
import { fmt } from "../i18n/i18n.js";
import { html } from "../../vendor/ui.js";

export function PutOff() {
  return putOff.value.map(
    ({ seconds, lost, stop }, i) => html`<p key=${i} class="notice warn">
      ${!lost && html`<strong>${t.overloaded}.</strong> `}${t.sendsAgain(fmt.value.count(seconds))}
      <button type="button" class="button small" onClick=${stop}>${t.doNotSend}</button>
    </p>`,
  );
}
