// Requests of a page, noted in the page itself: a test receives events of the browser late, and in
// no certain order.

/** @typedef {import("playwright-core").Page} Page */
/**
 * The times at which requests began, in ms, and the greatest number under way at once.
 * @typedef {{ times: number[], running: number, most: number }} Requests
 */

/** Methods that read a response. */
const READS = /** @type {const} */ (["json", "text", "arrayBuffer", "blob"]);

/**
 * Has pages opened from now on note their requests to paths with this end, each as under way until
 * the page has read its response.
 * @param {Page} page @param {string} end
 * @returns {Promise<() => Promise<Requests>>} the requests since the page was loaded
 */
export async function watchRequests(page, end) {
  await page.addInitScript(
    ([end, reads]) => {
      /** @type {Requests} */
      const requests = { times: [], running: 0, most: 0 };
      Object.assign(window, { requests });
      const own = window.fetch;
      window.fetch = async (input, init) => {
        const url = input instanceof Request ? input.url : `${input}`;
        if (!url.endsWith(end)) return own(input, init);
        requests.times.push(performance.now());
        requests.running += 1;
        requests.most = Math.max(requests.most, requests.running);
        let over = false;
        const ended = () => {
          if (!over) requests.running -= 1;
          over = true;
        };
        try {
          const response = await own(input, init);
          // a refused request may be sent again without being read
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
  return () => page.evaluate(() => /** @type {{ requests: Requests }} */ (/** @type {any} */ (window)).requests);
}
