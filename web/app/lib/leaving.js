// What ends with the part of a page that began it.

import { useEffect, useState } from "../../vendor/ui.js";

/** Ends what was begun once whoever uses this is shown no longer. @returns {AbortSignal} */
export function useLeaving() {
  const [abort] = useState(() => new AbortController());
  useEffect(() => () => abort.abort(), []);
  return abort.signal;
}
