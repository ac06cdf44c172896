// Parts that can be drawn later get a task of their own, so that none blocks the page for long.

import { underway } from "../api/resource.js";
import { turn } from "../lib/turn.js";
import { html, useLayoutEffect, useState } from "../../vendor/ui.js";

/**
 * @param {{ place: string, children: () => import("../../vendor/ui.js").ComponentChildren }} props `place`: the class of
 *   the placeholder until then
 */
export function Later({ place, children }) {
  const [there, setThere] = useState(false);
  useLayoutEffect(() => {
    let counted = true;
    underway.value += 1;
    const settle = () => {
      if (counted) underway.value -= 1;
      counted = false;
    };
    void turn().then(() => {
      if (counted) setThere(true);
      settle();
    });
    return settle;
  }, []);
  return there ? children() : html`<div class=${place}></div>`;
}
