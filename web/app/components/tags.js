// Tags of a job.

import { ABSENT } from "../lib/format.js";
import { html } from "../../vendor/ui.js";

/** @param {{ tags: Record<string, string> }} props */
export function Tags({ tags }) {
  const all = Object.entries(tags);
  if (all.length === 0) return ABSENT;
  return html`<span class="tags" translate="no">
    ${all.map(([name, value]) => html`<span key=${name} class="tag">${name} <b>${value}</b></span>`)}
  </span>`;
}
