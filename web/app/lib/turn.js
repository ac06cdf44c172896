/** Yields to the page's other work: timers wait 4 ms for nothing, and not every browser has `scheduler.yield`. */
export function turn() {
  return new Promise((resolve) => {
    const { port1, port2 } = new MessageChannel();
    port1.onmessage = () => {
      port1.close();
      resolve(undefined);
    };
    port2.postMessage(undefined);
  });
}
