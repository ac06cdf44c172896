// Manual choice of λ*: a slider in ln λ*, and its exact value.

import { TextField } from "../components/form.js";
import de from "../i18n/de/lambda.js";
import en from "../i18n/en/lambda.js";
import { fmt, texts } from "../i18n/i18n.js";
import { parseNumber } from "../lib/format.js";
import { h, html, useEffect, useId, useState } from "../../vendor/ui.js";
import { partOf, valueAt } from "./selection.js";

const t = texts({ en, de });
const STEPS = 500;

/**
 * @param {{ range: readonly [number, number], value: number | undefined, symbol: string, ranks: boolean, onMove: (value: number, settled: boolean) => void }} props
 *   `settled`: it was let go, or a value was entered
 */
export function LambdaSlider({ range, value, symbol, ranks, onMove }) {
  const id = useId();
  const [text, setText] = useState(/** @type {string | undefined} */ (undefined));
  useEffect(() => setText(undefined), [value]);
  const written = ranks ? fmt.value.count(value) : fmt.value.three(value);
  const entered = text === undefined ? undefined : parseNumber(text);
  const wrong =
    entered !== undefined && !(entered >= range[0] * (1 - 1e-9) && entered <= range[1] * (1 + 1e-9) && entered > 0);
  const take = (/** @type {Event} */ event) => {
    event.preventDefault();
    if (entered !== undefined && !wrong) onMove(ranks ? Math.round(entered) : entered, true);
  };
  const move =
    (/** @type {boolean} */ settled) =>
    (/** @type {import("../../vendor/ui.js").TargetedEvent<HTMLInputElement>} */ event) => {
      const at = Number(event.currentTarget.value);
      onMove(ranks ? at : valueAt(range, at / STEPS), settled);
    };
  const [least, most] = ranks ? [range[0], range[1]] : [0, STEPS];
  const at = ranks ? (value ?? range[1]) : Math.round(STEPS * partOf(range, value));
  const name = ranks ? t.rank : t.sliderOf(symbol);
  return html`<div class="lambda-slider">
    <label for=${id}>${name} <output translate="no">${written}</output></label>
    <input id=${id} type="range" min=${least} max=${most} step="1" value=${at} aria-valuetext=${written} onInput=${move(false)} onChange=${move(true)} />
    <p class="lambda-ends quiet" translate="no"><span>${ranks ? range[0] : `λ₁ ${fmt.value.three(range[0])}`}</span><span>${ranks ? range[1] : `λₙ ${fmt.value.three(range[1])}`}</span></p>
    <form class="lambda-exact" onSubmit=${take}>
      ${h(TextField, {
        label: t.exactValue,
        value: text ?? fmt.value.input(ranks ? value : shortened(value)),
        onInput: setText,
        numeric: true,
        required: true,
        fieldError: wrong ? t.outside(fmt.value.three(range[0]), fmt.value.three(range[1])) : undefined,
      })}
      <button type="submit" class="button" disabled=${entered === undefined || wrong}>${t.show}</button>
    </form>
  </div>`;
}

/** Formats the initial value: six digits are enough. @param {number | undefined} value */
const shortened = (value) => (value === undefined ? undefined : Number(value.toPrecision(6)));
