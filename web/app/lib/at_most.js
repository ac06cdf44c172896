// What many news ask for is done once for those that come close together.

import { useEffect, useRef } from "../../vendor/ui.js";

/** Does at once what has rested for long enough, and else as soon as it has. @param {number} wait in ms @param {() => void} act */
export function useAtMostEvery(wait, act) {
  const last = useRef(Number.NEGATIVE_INFINITY);
  const timer = useRef(/** @type {ReturnType<typeof setTimeout> | undefined} */ (undefined));
  useEffect(() => () => clearTimeout(timer.current), []);
  return () => {
    clearTimeout(timer.current);
    const now = () => {
      last.current = performance.now();
      act();
    };
    const rest = wait - (performance.now() - last.current);
    if (rest <= 0) now();
    else timer.current = setTimeout(now, rest);
  };
}
