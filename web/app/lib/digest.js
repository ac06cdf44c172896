// Short digests that distinguish contents; the browser's own need a secure origin. Pure.

/**
 * Digests a text or bytes. Collisions are as rare as one in 2⁵³; should a request ever reuse a key,
 * the server refuses it, since it knows the body.
 * @param {string | Uint8Array} content
 */
export function digestOf(content) {
  const at =
    typeof content === "string"
      ? (/** @type {number} */ i) => content.charCodeAt(i)
      : (/** @type {number} */ i) => content[i] ?? 0;
  // cyrb53: two rounds of multiplication
  let [a, b] = [0xdeadbeef, 0x41c6ce57];
  for (let i = 0; i < content.length; i += 1) {
    const code = at(i);
    a = Math.imul(a ^ code, 2654435761);
    b = Math.imul(b ^ code, 1597334677);
  }
  a = Math.imul(a ^ (a >>> 16), 2246822507) ^ Math.imul(b ^ (b >>> 13), 3266489909);
  b = Math.imul(b ^ (b >>> 16), 2246822507) ^ Math.imul(a ^ (a >>> 13), 3266489909);
  return `${content.length}-${(b >>> 0).toString(16)}-${(a >>> 0).toString(16)}`;
}
