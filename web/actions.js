/** What can be done with a job, by its state. */

import { change, remove, retry } from "./api.js";
import { element } from "./dom.js";

// Not DELETE, which would take the picture of a job that has ended in the meantime.
const CANCEL = { label: "Cancel", run: (id) => change(id, { state: "cancelled" }) };
const PAUSE = { label: "Pause", run: (id) => change(id, { state: "paused" }) };
const RESUME = { label: "Resume", run: (id) => change(id, { state: "queued" }), primary: true };
const RETRY = { label: "Retry", run: retry, primary: true };
const DELETE = { label: "Delete", run: remove, deletes: true };

const ACTIONS = {
  queued: [PAUSE, CANCEL],
  running: [PAUSE, CANCEL],
  paused: [RESUME, CANCEL],
  done: [DELETE],
  failed: [RETRY, DELETE],
  cancelled: [RETRY, DELETE],
};

/**
 * The buttons of one job: {element, set(state)}. onDone(deleted) runs after the server has agreed,
 * onFault(error) when it has not. From a click to the set() that follows the answer, clicks do nothing: a second one
 * would mean what stands there next.
 */
export function actionBar(id, { onDone, onFault }) {
  const bar = element("div", { class: "actions", role: "group", "aria-label": "Actions" });
  let shown = null;
  let waiting = null; // "answer", then "state"

  async function run(action) {
    if (waiting || (action.deletes && !(await confirmed(bar)))) return;
    wait("answer");
    try {
      await action.run(id);
      wait("state");
      onDone(action.deletes === true);
    } catch (error) {
      wait(null);
      onFault(error);
    }
  }

  function wait(what) {
    waiting = what;
    // Not `disabled`: the focus would fall to the body.
    for (const button of bar.querySelectorAll(":scope > button")) button.setAttribute("aria-disabled", String(what !== null));
  }

  return {
    element: bar,
    set(state) {
      if (state !== shown) {
        shown = state;
        const focused = bar.contains(document.activeElement);
        bar.replaceChildren(...ACTIONS[state].map((action) => element("button", {
          type: "button", class: action.primary ? "primary" : action.deletes ? "danger" : null, onclick: () => run(action),
        }, action.label)));
        if (focused) bar.querySelector("button")?.focus();
      }
      wait(waiting === "answer" ? "answer" : null);
    },
  };
}

/** Asks before a picture is deleted for good. Escape keeps it. */
function confirmed(place) {
  return new Promise((resolve) => {
    const dialog = element("dialog", { "aria-labelledby": "delete-title" },
      element("h2", { id: "delete-title" }, "Delete this job?"),
      element("p", {}, "Its picture, curve and statistics are deleted with it. This cannot be undone."),
      element("div", { class: "actions" },
        element("button", { type: "button", autofocus: true, onclick: () => dialog.close("keep") }, "Keep"),
        element("button", { type: "button", class: "danger", onclick: () => dialog.close("delete") }, "Delete")));
    dialog.addEventListener("close", () => {
      resolve(dialog.returnValue === "delete");
      dialog.remove();
    }, { once: true });
    place.append(dialog);
    dialog.showModal();
  });
}
