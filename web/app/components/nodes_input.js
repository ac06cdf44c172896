// Nodes from a dropped or chosen file, or from pasted text.

import de from "../i18n/de/fit.js";
import en from "../i18n/en/fit.js";
import { texts } from "../i18n/i18n.js";
import { isJson, readNodes, textOfTable } from "../lib/nodes_file.js";
import { readTable } from "../lib/nodes_table.js";
import { h, html, useId, useState } from "../../vendor/ui.js";
import { TextField } from "./form.js";
import { Failure } from "./states.js";

/** @typedef {import("../lib/nodes_file.js").NodesFile} NodesFile */
/** @typedef {{ text: string, name: string }} NodesText `name`: of the file, empty where it was pasted */

const t = texts({ en, de });

/**
 * @param {{ onNodes: (file: NodesFile, name: string) => void, onRefused: () => void }} props `onRefused`: called for a text
 *   that holds no nodes
 */
export function NodesInput({ onNodes, onRefused }) {
  const id = useId();
  const [over, setOver] = useState(false);
  const [pasted, setPasted] = useState("");
  const [failure, setFailure] = useState(/** @type {{ text: string, name: string } | undefined} */ (undefined));
  const [refused, setRefused] = useState(/** @type {{ error: unknown, name: string } | undefined} */ (undefined));
  const take = (/** @type {string} */ text, /** @type {string} */ name) => {
    const read = readNodes(text);
    setFailure(read.failure && { text: t[read.failure], name });
    if (read.file) onNodes(read.file, name);
    else onRefused();
  };
  // the server reads tables, by their bytes: these may have any character set
  const takeBytes = async (/** @type {Blob} */ bytes, /** @type {string} */ name) => {
    setRefused(undefined);
    const text = await bytes.text();
    if (isJson(text) || text.trim() === "") return take(text, name);
    try {
      const proposal = await readTable(bytes, undefined);
      if (proposal.read) return take(textOfTable(proposal), name);
      setFailure({ text: t.noNodes, name });
    } catch (error) {
      setFailure(undefined);
      setRefused({ error, name });
    }
    onRefused();
  };
  const takeFile = (/** @type {File | null | undefined} */ file) => file && takeBytes(file, file.name);
  const drop = (/** @type {DragEvent} */ event) => {
    event.preventDefault();
    setOver(false);
    takeFile(event.dataTransfer?.files[0]);
  };
  const drag = (/** @type {DragEvent} */ event) => {
    event.preventDefault();
    setOver(true);
  };
  return html`<section class="panel" aria-labelledby=${`${id}-nodes`}>
    <h2 id=${`${id}-nodes`}>${t.nodes}</h2>
    <div class=${`drop${over ? " over" : ""}`} onDragOver=${drag} onDragLeave=${() => setOver(false)} onDrop=${drop}>
      <label for=${`${id}-file`}>${t.drop}</label>
      <input id=${`${id}-file`} type="file" accept=".json,.csv,.txt,.dat,.tsv" aria-describedby=${`${id}-hint`}
        onChange=${(/** @type {import("../../vendor/ui.js").TargetedEvent<HTMLInputElement>} */ event) => takeFile(event.currentTarget.files?.[0])} />
      <p class="hint" id=${`${id}-hint`}>${t.dropHint}</p>
    </div>
    <details>
      <summary>${t.paste}</summary>
      <div class="pasted">
        ${h(TextField, { label: t.pasted, required: true, value: pasted, onInput: setPasted, lines: 6, hint: t.pasteHint })}
        <div class="actions"><button type="button" class="button" onClick=${() => takeBytes(new Blob([pasted]), "")}>${t.fitNow}</button></div>
      </div>
    </details>
    <div aria-live="polite">
      ${failure && html`<p class="field-error">${failure.name && html`<span translate="no">${failure.name}</span>`} ${failure.text}</p>`}
      ${refused?.name && html`<p class="field-error" translate="no">${refused.name}</p>`}
      ${refused && h(Failure, { error: refused.error })}
    </div>
  </section>`;
}
