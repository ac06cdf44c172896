// Idempotency keys for POSTs that store. The same content keeps its key until it has been stored,
// also over a reload, since the response to a stored request may have been lost.

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
      // without storage the key is kept as long as the page is shown
    }
  }

  /** Returns the headers of a request with this content. @param {unknown} content */
  headers(content) {
    const digest = digestOf(JSON.stringify(content));
    if (digest !== this.#digest || this.#key === "") {
      [this.#digest, this.#key] = [digest, newKey()];
      this.#keep(JSON.stringify([this.#digest, this.#key]));
    }
    return { "Idempotency-Key": this.#key };
  }

  /** Marks the content as stored; the next request gets a new key. */
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

/** Returns the attempts of a form. @param {string} name */
export function useAttempt(name) {
  return useState(() => new Attempt(name))[0];
}

/** @returns {string} */
function newKey() {
  // not `randomUUID`, which requires a secure origin
  const bytes = crypto.getRandomValues(new Uint8Array(16));
  return [...bytes].map((byte) => byte.toString(16).padStart(2, "0")).join("");
}
