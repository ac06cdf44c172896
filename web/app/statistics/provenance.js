// The provenance of a fit: engine, arithmetic, input digest, and its replay.

import { answer, api } from "../api/client.js";
import { may } from "../api/key.js";
import { Badge, Facts } from "../components/figure.js";
import { Failure } from "../components/states.js";
import de from "../i18n/de/statistics.js";
import en from "../i18n/en/statistics.js";
import { fmt, texts } from "../i18n/i18n.js";
import { h, html, useState } from "../../vendor/ui.js";

/** @typedef {import("../api/client.js").Schema<"IterationFit">} IterationFit */
/** @typedef {import("../api/client.js").Schema<"Replay">} Replay */

const t = texts({ en, de });

/** @param {{ fit: IterationFit, path: { job_id: string, number: number } }} props */
export function Provenance({ fit: { id, created_at, result }, path }) {
  const [replay, setReplay] = useState(/** @type {{ data?: Replay, error?: unknown, busy?: boolean }} */ ({}));
  const run = async () => {
    setReplay({ busy: true });
    try {
      const params = { path: { ...path, fit_id: id } };
      const { data } = await answer(api.POST("/v1/jobs/{job_id}/iterations/{number}/fits/{fit_id}/replay", { params }));
      setReplay({ data });
    } catch (error) {
      setReplay({ error });
    }
  };
  const data = (/** @type {string} */ text) => html`<span translate="no">${text}</span>`;
  return html`<section class="panel">
    <header><h2>${t.provenance}</h2>${may("compute") && html`<button type="button" class="button" disabled=${replay.busy ?? false} onClick=${run}>${t.replay}</button>`}</header>
    <div aria-live="polite">${replay.data && h(ReplayAnswer, { replay: replay.data })}</div>
    ${replay.error !== undefined && h(Failure, { error: replay.error, retry: run })}
    ${h(Facts, {
      columns: true,
      items: [
        { name: t.digits, value: data(fmt.value.fixed(result.numerics.correct_digits, 1)) },
        { name: t.arithmetic, value: t[result.numerics.arithmetic] ?? data(result.numerics.arithmetic) },
        { name: t.engine, value: data(result.provenance.engine) },
        { name: t.digest, value: html`<code class="digest" translate="no">${result.provenance.input_sha256}</code>` },
        { name: t.made, value: data(fmt.value.time(created_at)) },
        { name: t.fitId, value: html`<code translate="no">${id}</code>` },
      ],
    })}
  </section>`;
}

/** @param {{ replay: Replay }} props */
function ReplayAnswer({ replay }) {
  if (replay.identical) return html`<p>${h(Badge, { kind: "good", children: t.identical })} ${t.identicalText}</p>`;
  return html`<p>${h(Badge, { kind: "warn", children: t.differs })} ${t.differsText(fmt.value.three(replay.max_relative_difference))}
    <span translate="no">${replay.stored_engine} → ${replay.replay_engine}</span></p>`;
}
