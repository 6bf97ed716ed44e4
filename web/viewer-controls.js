/** What stands under the picture: exposure, tone, size, the map of the error, and the files to keep. */

import { element, setText } from "./dom.js";

const LIMIT = 8; // stops

export function viewerControls(viewer, job) {
  const value = element("output", { for: "exposure" });
  const exposure = element("input", { id: "exposure", type: "range", min: -LIMIT, max: LIMIT, step: 0.1, value: 0, oninput: apply });
  const tone = element("select", { id: "tone", onchange: apply },
    element("option", { value: "clip" }, "sRGB, as the PNG"),
    element("option", { value: "compress" }, "Compress highlights"));
  const reset = element("button", { type: "button", onclick: () => { exposure.value = 0; tone.value = "clip"; apply(); } }, "Reset");
  const size = element("button", { type: "button", "aria-pressed": "false", onclick: resize }, "Actual size");

  const map = element("button", { type: "button", "aria-pressed": "false", onclick: showMap }, "Error map");
  const mapped = element("img", { class: "error-map", hidden: true, alt: "The relative error about each pixel, from black (1e-6 or less) to bright (1 or more)" });
  viewer.canvas.after(mapped);

  /** The map as it stands now, in the picture's place, or the picture again. */
  function showMap() {
    const on = mapped.hidden;
    if (on) mapped.src = `${job.links.error_map}?at=${Date.now()}`;
    mapped.hidden = !on;
    viewer.canvas.hidden = on;
    map.setAttribute("aria-pressed", String(on));
  }

  function apply() {
    const stops = Number(exposure.value);
    setText(value, `${stops > 0 ? "+" : ""}${stops.toFixed(1)} EV`);
    viewer.setTone(stops, tone.value);
  }

  function resize() {
    const actual = viewer.canvas.classList.toggle("actual");
    mapped.classList.toggle("actual", actual);
    size.setAttribute("aria-pressed", String(actual));
  }

  apply();
  return element("div", {},
    element("div", { class: "controls" },
      element("span", { class: "pair" }, element("label", { for: "exposure" }, "Exposure"), exposure, value),
      element("span", { class: "pair" }, element("label", { for: "tone" }, "Tone"), tone),
      element("span", { class: "pair" }, reset, size, map)),
    element("p", { class: "downloads" }, "Download ",
      ...files(job).map(([label, address, name]) => element("a", { class: "button", href: address, download: name }, label))));
}

function files({ id, links }) {
  return [
    ["PNG", links.image, `${id}.png`],
    ["EXR", links.exr, `${id}.exr`],
    ["Statistics", links.stats, `${id}-stats.json`],
    ["Curve", links.curve, `${id}-curve.json`],
  ];
}
