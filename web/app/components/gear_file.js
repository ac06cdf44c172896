// Gears of a file, to be copied into a form.

import { answer, api } from "../api/client.js";
import { t as common } from "../i18n/common.js";
import de from "../i18n/de/new_job.js";
import en from "../i18n/en/new_job.js";
import { texts } from "../i18n/i18n.js";
import { ABSENT } from "../lib/format.js";
import { gearInShort } from "../lib/gear.js";
import { h, html, useRef, useState } from "../../vendor/ui.js";
import { GearWarnings } from "./gear_fields.js";
import { Failure } from "./states.js";

/** @typedef {import("../api/client.js").Schema<"Gear">} Gear */
/** @typedef {import("../api/client.js").Schema<"GearsOfFile">} GearsOfFile */
/** @typedef {{ gears?: GearsOfFile, error?: unknown, reading?: boolean, taken?: number }} State */

const t = texts({ en, de });

/** @param {{ onTake: (gear: Gear, name: string | undefined) => void }} props */
export function GearFile({ onTake }) {
  const [state, setState] = useState(/** @type {State} */ ({}));
  const newest = useRef(0);
  const read = async (/** @type {File | undefined} */ file) => {
    if (!file) return;
    newest.current += 1;
    const turn = newest.current;
    setState({ reading: true });
    const form = new FormData();
    form.append("file", file);
    const sent = api.POST("/v1/gears/read", { body: { file: file.name }, bodySerializer: () => form });
    const next = await answer(sent).then(
      ({ data }) => ({ gears: data }),
      (/** @type {unknown} */ error) => ({ error }),
    );
    if (turn === newest.current) setState(next);
  };
  const { gears, error, reading, taken } = state;
  const take = (/** @type {number} */ index) => {
    const one = gears?.gears[index];
    if (!gears || !one?.gear) return;
    onTake(one.gear, one.name ?? undefined);
    setState({ gears, taken: index });
  };
  return html`<div class="field">
    <label for="gear-file">${t.fromFile} <span class="optional">${common.optional}</span></label>
    <input id="gear-file" type="file" accept=".rexs,.rexsz,.xml,.mka,.mew" aria-describedby="gear-file-hint"
      onChange=${(/** @type {import("../../vendor/ui.js").TargetedEvent<HTMLInputElement>} */ event) => read(event.currentTarget.files?.[0])} />
    <div class="notes" aria-live="polite">
      <p class="hint" id="gear-file-hint">${t.fromFileHint}</p>
      ${reading && html`<p>${t.reading}</p>`}
      ${error !== undefined && h(Failure, { error })}
      ${gears && h(Found, { found: gears, taken, take })}
    </div>
  </div>`;
}

/** @param {{ found: GearsOfFile, taken: number | undefined, take: (index: number) => void }} props */
function Found({ found: { gears, warnings }, taken, take }) {
  return html`<p>${gears.length === 0 ? t.noGears : t.gearsOfFile(gears.length)}</p>
    <ul class="gears">
      ${gears.map(
        ({ name, gear, missing }, i) => html`<li key=${i}>
          <span>
            <b>${name ? html`<span translate="no">${name}</span>` : t.unnamed}</b>
            ${
              gear
                ? html` <span class="quiet" translate="no">${gearInShort(gear)}</span>`
                : html` <span class="quiet">${t.missing((missing ?? []).join(", ") || ABSENT)}</span>`
            }
          </span>
          ${gear && (taken === i ? html`<span class="quiet">${t.taken}</span>` : html`<button type="button" class="button small" onClick=${() => take(i)}>${t.take}</button>`)}
        </li>`,
      )}
    </ul>
    ${h(GearWarnings, { warnings })}`;
}
