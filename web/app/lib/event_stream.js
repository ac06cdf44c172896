// Reads server-sent events as they arrive, in pieces of any size (HTML, 9.2.6).

/** @typedef {{ id: string, event: string, data: string }} ServerEvent */

/**
 * Returns a reader: each piece yields the events that it completes.
 * @returns {(piece: string) => ServerEvent[]}
 */
export function eventReader() {
  let rest = "";
  let begun = false;
  /** @type {string[]} */
  let data = [];
  let event = "";
  // the ID stays until another one is given
  let id = "";

  /** @param {string} line @param {ServerEvent[]} complete */
  const take = (line, complete) => {
    if (line === "") {
      if (data.length > 0) complete.push({ id, event: event || "message", data: data.join("\n") });
      data = [];
      event = "";
      return;
    }
    const colon = line.indexOf(":");
    if (colon === 0) return;
    const field = colon < 0 ? line : line.slice(0, colon);
    const value = colon < 0 ? "" : line.slice(colon + 1).replace(/^ /, "");
    if (field === "data") data.push(value);
    else if (field === "event") event = value;
    else if (field === "id" && !value.includes("\0")) id = value;
  };

  return (piece) => {
    rest += piece;
    if (!begun && rest.length > 0) {
      begun = true;
      rest = rest.replace(/^\uFEFF/, "");
    }
    /** @type {ServerEvent[]} */
    const complete = [];
    for (;;) {
      const end = /\r\n|\n|\r/.exec(rest);
      // a carriage return at the end may be half of a line break
      if (!end || (end[0] === "\r" && end.index === rest.length - 1)) return complete;
      take(rest.slice(0, end.index), complete);
      rest = rest.slice(end.index + end[0].length);
    }
  };
}

/** Yields the events that each piece of a body completes. @param {ReadableStream<Uint8Array>} body */
export async function* eventsOf(body) {
  const reader = body.getReader();
  const decoder = new TextDecoder();
  const events = eventReader();
  for (;;) {
    const { done, value } = await reader.read();
    if (done) return;
    yield events(decoder.decode(value, { stream: true }));
  }
}
