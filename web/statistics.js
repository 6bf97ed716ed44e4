/** A job's statistics as a list of terms, and the features that its scene used and left out. */

import { element } from "./dom.js";
import { bytes, count, duration, interval, percent, scientific, short } from "./format.js";

/** {element, set(statistics)}; the contract of --stats. What is missing is left out. */
export function statisticsTable() {
  const body = element("div", { class: "statistics" }, element("p", { class: "quiet" }, "None yet."));
  return {
    element: body,
    set(statistics) {
      body.replaceChildren(
        element("dl", {}, ...terms(statistics).flatMap(([term, text]) => [
          element("dt", {}, term), element("dd", {}, text)])),
        ...features("Used", statistics.features?.used, "used"),
        ...features("Left out", statistics.features?.left_out, "left-out"));
    },
  };
}

function terms({ seconds = {}, rays = {}, accelerator = {}, error, samples, rays_per_second: speed, kernel }) {
  const rows = [];
  const add = (term, value, text) => {
    if (value !== undefined && value !== null) rows.push([term, text(value)]);
  };
  add("Samples a pixel", samples, count);
  for (const [name, term] of [["load", "Load"], ["compile", "Compile"], ["render", "Render"], ["write", "Write"]]) {
    add(term, seconds[name], duration);
  }
  add("Camera rays", rays.camera, short);
  add("Bounce rays", rays.bounce, short);
  add("Shadow rays", rays.shadow, short);
  add("Rays a second", speed, short);
  add("Relative MSE", error?.relative_mse, scientific);
  if (error && error.high > 0) rows.push(["95% interval", interval(error.low, error.high)]);
  if (error?.heavy_tailed) rows.push(["Rare events", `${percent(error.tail_share)} of the error: it may be understated`]);
  add("MSE", error?.mse, scientific);
  add("Accelerator", accelerator.kind, String);
  add("Nodes", accelerator.nodes, count);
  add("Accelerator size", accelerator.bytes, bytes);
  add("Accelerator build", accelerator.seconds, duration);
  add("Kernel", kernel, String);
  return rows;
}

function features(title, names, kind) {
  if (!names?.length) return [];
  return [element("div", { class: "features" }, element("h3", {}, title),
    element("ul", {}, ...names.map((name) => element("li", { class: kind }, name))))];
}
