// Tolerances of a class of ISO 1328-1 for a gear.

import { CLASSES } from "../lib/requirements.js";
import { answer, api } from "./client.js";
import { may } from "./key.js";
import { useResource } from "./resource.js";

/** @typedef {import("./client.js").Schema<"Gear">} Gear */

/** Returns the tolerances of a class; requests nothing without gear or class. @param {Gear | null | undefined} gear @param {string} of */
export function useTolerances(gear, of) {
  const wanted = gear && CLASSES.includes(of) && may("compute");
  return useResource(wanted ? `tolerances ${of} ${JSON.stringify(gear)}` : null, (signal) =>
    answer(
      api.POST("/v1/gears/tolerances", {
        signal,
        body: { gear: /** @type {Gear} */ (gear), class: Number(of) },
      }),
    ),
  );
}
