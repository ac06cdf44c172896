// The position of a value in its limits, and its conformity.

import { t } from "../i18n/requirements.js";
import { ABSENT } from "../lib/format.js";
import { h, html } from "../../vendor/ui.js";
import { Badge } from "./figure.js";

/** By a sign and in words, by the verdict where there is one; nothing without limits. @param {{ within?: boolean | null | undefined, conformity?: Verdict | null | undefined }} props */
export function Within({ within, conformity }) {
  if (conformity) return h(Decided, { conformity });
  if (typeof within !== "boolean") return null;
  return html`<b class=${within ? "within good" : "within bad"}><span aria-hidden="true" translate="no">${within ? "✓" : "✗"}</span><span
    class="visually-hidden">${within ? t.within : t.outside}</span></b>`;
}

/** @typedef {import("../api/client.js").Schema<"Conformity">} Conformity */
/** The part of a conformity that is shown. @typedef {Pick<Conformity, "verdict" | "assumptions" | "reasons">} Verdict */

/** Verdicts with sign and colour; one with doubtful assumptions has no ✓. */
export const VERDICTS = /** @type {const} */ ({
  conforms: { sign: "✓", kind: "good" },
  does_not_conform: { sign: "✗", kind: "bad" },
  undecidable: { sign: "?", kind: "warn" },
  doubtful: { sign: "!", kind: "warn" },
});

/** The key of a verdict, and the reasons to doubt it in words. @param {Verdict} conformity */
export function verdictOf({ verdict, assumptions, reasons }) {
  /** @type {keyof typeof VERDICTS} */
  const key = verdict === "conforms" && assumptions === "doubtful" ? "doubtful" : verdict;
  return { key, why: reasons.map(t.because).join(", ") };
}

/** @param {Verdict | undefined} conformity */
export function verdictText(conformity) {
  if (!conformity) return undefined;
  const { why } = verdictOf(conformity);
  const verdict = t[conformity.verdict];
  if (conformity.assumptions === "ok") return verdict;
  return why ? `${verdict}, ${t.doubtful}: ${why}` : `${verdict}, ${t.doubtful}`;
}

/** A verdict by its sign, for narrow columns. @param {{ conformity: Verdict | undefined }} props */
export function Decided({ conformity }) {
  if (!conformity) return null;
  const { key } = verdictOf(conformity);
  return html`<b class=${`within ${VERDICTS[key].kind}`} title=${verdictText(conformity)}><span aria-hidden="true" translate="no">${VERDICTS[key].sign}</span><span
    class="visually-hidden">${verdictText(conformity)}</span></b>`;
}

/** A verdict in words, with the reasons to doubt it unless they are elsewhere. @param {{ conformity: Conformity | undefined, brief?: boolean }} props */
export function Conforms({ conformity, brief = false }) {
  if (!conformity) return ABSENT;
  const { key, why } = verdictOf(conformity);
  return html`${h(Badge, { kind: VERDICTS[key].kind, children: t[key] })}${!brief && why && html`<span class="quiet why">${why}</span>`}`;
}
