// A gear in a short line.

import { fmt } from "../i18n/i18n.js";

/** @typedef {import("../api/client.js").Schema<"Gear">} Gear */

/** Formats a gear such as `z 52 · mₙ 1 mm · β 28°`. @param {Gear | null | undefined} gear */
export function gearInShort(gear) {
  if (!gear) return undefined;
  const parts = [`z ${gear.internal ? "−" : ""}${gear.teeth}`, `mₙ ${fmt.value.input(gear.normal_module_mm)} mm`];
  if (gear.helix_angle_deg) parts.push(`β ${fmt.value.input(gear.helix_angle_deg)}°`);
  return parts.join(" · ");
}
