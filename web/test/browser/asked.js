// What a page asks for, noted in the page itself: of events of the browser a test hears late, and
// in no certain order.

/** @typedef {import("playwright-core").Page} Page */
/**
 * When each request began, in ms, and how many were under way at once.
 * @typedef {{ times: number[], running: number, most: number }} Asked
 */

/** What reads a response. */
const READS = /** @type {const} */ (["json", "text", "arrayBuffer", "blob"]);

/**
 * Has the pages that are opened from now on note their requests to places that end so, each as
 * under way until the page has read its answer.
 * @param {Page} page @param {string} end
 * @returns {Promise<() => Promise<Asked>>} what was asked since the page was loaded
 */
export async function watchAsked(page, end) {
  await page.addInitScript(
    ([end, reads]) => {
      /** @type {Asked} */
      const asked = { times: [], running: 0, most: 0 };
      Object.assign(window, { asked });
      const own = window.fetch;
      window.fetch = async (input, init) => {
        const url = input instanceof Request ? input.url : `${input}`;
        if (!url.endsWith(end)) return own(input, init);
        asked.times.push(performance.now());
        asked.running += 1;
        asked.most = Math.max(asked.most, asked.running);
        let over = false;
        const ended = () => {
          if (!over) asked.running -= 1;
          over = true;
        };
        try {
          const response = await own(input, init);
          // what is refused may be asked again and not be read
          if (!response.ok) ended();
          for (const name of reads) {
            const read = response[name].bind(response);
            Object.assign(response, { [name]: () => read().finally(ended) });
          }
          return response;
        } catch (error) {
          ended();
          throw error;
        }
      };
    },
    /** @type {const} */ ([end, READS]),
  );
  return () => page.evaluate(() => /** @type {{ asked: Asked }} */ (/** @type {any} */ (window)).asked);
}
