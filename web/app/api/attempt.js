// Keys for POSTs that store: the same content is sent under the same key, however often it is tried, until it has been
// stored; over a reload too, since an answer that was lost may have come of what is stored.

import { digestOf } from "../lib/digest.js";
import { useState } from "../../vendor/ui.js";

export class Attempt {
  #place;
  #digest = "";
  #key = "";

  /** @param {string} name of what is sent, the same for another try */
  constructor(name) {
    this.#place = `flankfit.attempt ${name}`;
    try {
      const [digest, key] = JSON.parse(globalThis.sessionStorage?.getItem(this.#place) ?? "[]");
      if (typeof digest === "string" && typeof key === "string") [this.#digest, this.#key] = [digest, key];
    } catch {
      // a browser that keeps nothing has the key as long as the page is shown
    }
  }

  /** The headers of a request with this content. @param {unknown} content */
  headers(content) {
    const digest = digestOf(JSON.stringify(content));
    if (digest !== this.#digest || this.#key === "") {
      [this.#digest, this.#key] = [digest, newKey()];
      this.#keep(JSON.stringify([this.#digest, this.#key]));
    }
    return { "Idempotency-Key": this.#key };
  }

  /** It has been stored; the next is another. */
  done() {
    this.#key = "";
    this.#keep(undefined);
  }

  /** @param {string | undefined} text */
  #keep(text) {
    try {
      if (text === undefined) globalThis.sessionStorage?.removeItem(this.#place);
      else globalThis.sessionStorage?.setItem(this.#place, text);
    } catch {
      // as above
    }
  }
}

/** The attempts of a form. @param {string} name */
export function useAttempt(name) {
  return useState(() => new Attempt(name))[0];
}

/** @returns {string} */
function newKey() {
  // not `randomUUID`, which browsers have on secure origins only
  const bytes = crypto.getRandomValues(new Uint8Array(16));
  return [...bytes].map((byte) => byte.toString(16).padStart(2, "0")).join("");
}
