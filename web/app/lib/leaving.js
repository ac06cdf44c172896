// Work that ends with the part of a page that began it.

import { useEffect, useState } from "../../vendor/ui.js";

/** Aborts once the component is no longer shown. @returns {AbortSignal} */
export function useLeaving() {
  const [abort] = useState(() => new AbortController());
  useEffect(() => () => abort.abort(), []);
  return abort.signal;
}
