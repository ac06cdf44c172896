// Media queries of the window, followed as they change.

import { useEffect, useState } from "../../vendor/ui.js";

/** Tablets at the machine and narrower windows: controls are larger, and there is less space. As in `styles/tokens.css`. */
export const TABLET = "(max-width: 1023.98px)";

/** Returns the state of a media query. @param {string} query */
export function useMedia(query) {
  const [holds, setHolds] = useState(() => matchMedia(query).matches);
  useEffect(() => {
    const media = matchMedia(query);
    const follow = () => setHolds(media.matches);
    follow();
    media.addEventListener("change", follow);
    return () => media.removeEventListener("change", follow);
  }, [query]);
  return holds;
}
