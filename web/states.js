/** The states of a job, as the page shows them. */

import { element, setText } from "./dom.js";

export const STATES = ["queued", "running", "paused", "done", "failed", "cancelled"];
const ENDED = new Set(["done", "failed", "cancelled"]);

export const hasEnded = (state) => ENDED.has(state);

/** A label that keeps its element: {element, set(state)}. */
export function stateLabel() {
  const label = element("span", { class: "state" });
  return {
    element: label,
    set(state) {
      setText(label, state);
      if (label.dataset.state !== state) label.dataset.state = state;
    },
  };
}
