/** Error against run time, both axes logarithmic: the estimate, its 95% band, and the slope to expect. */

import { element, svg } from "./dom.js";
import { count, duration, interval, power, scientific } from "./format.js";

const WIDTH = 380;
const HEIGHT = 270;
const MARGIN = { left: 66, right: 10, top: 8, bottom: 42 };
const THINNEST = 1.5; // units between two points that are both drawn

export class CurveChart {
  #points = [];
  #frame = 0;
  #plot = svg("g");
  #marker = svg("circle", { class: "curve-marker", r: 5, visibility: "hidden" });
  #readout = element("p", { class: "curve-readout", "aria-live": "off" });
  #rows = element("tbody");
  #drawn = []; // [{x, y, point}], for the pointer

  constructor(signal) {
    const picture = svg("svg", {
      viewBox: `0 0 ${WIDTH} ${HEIGHT}`, class: "curve", role: "img",
      "aria-label": "Relative mean squared error against seconds, both logarithmic. The figures are in the table below.",
    }, this.#plot, this.#marker);
    picture.addEventListener("pointermove", (event) => this.#point(picture, event));
    picture.addEventListener("pointerleave", () => this.#leave());
    this.element = element("div", {}, picture, this.#readout,
      element("details", {}, element("summary", {}, "Figures"),
        element("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": "Error against run time" },
          element("table", {},
            element("thead", {}, element("tr", {}, ...["Time", "Samples", "relMSE", "95% interval", "MSE"].map(
              (title) => element("th", { scope: "col" }, title)))),
            this.#rows))));
    signal.addEventListener("abort", () => cancelAnimationFrame(this.#frame), { once: true });
    this.set([]);
  }

  /** points: [{seconds, samples, mse, relative_mse, low, high}] */
  set(points) {
    this.#points = points.filter(isDrawable).sort((a, b) => a.samples - b.samples);
    this.#later();
  }

  /** A point that has just been reached; one of the same sample count is replaced. */
  add(point) {
    if (!isDrawable(point)) return;
    this.set([...this.#points.filter((other) => other.samples !== point.samples), point]);
  }

  #later() {
    if (this.#frame) return;
    this.#frame = requestAnimationFrame(() => {
      this.#frame = 0;
      this.#draw();
    });
  }

  #draw() {
    const points = this.#points;
    this.#leave();
    if (points.length === 0) {
      this.#drawn = [];
      this.#plot.replaceChildren(svg("text", { x: WIDTH / 2, y: HEIGHT / 2, class: "curve-empty", "text-anchor": "middle" },
        "The first checkpoint is yet to come."));
      this.#rows.replaceChildren();
      return;
    }
    const x = axis(points.map((point) => point.seconds), MARGIN.left, WIDTH - MARGIN.right);
    const bounds = points.flatMap((point) => [point.relative_mse, point.low, point.high]).filter((value) => value > 0);
    const y = axis(bounds, HEIGHT - MARGIN.bottom, MARGIN.top);
    this.#drawn = thin(points.map((point) => ({ x: x.at(point.seconds), y: y.at(point.relative_mse), point })));
    this.#plot.replaceChildren(...frame(x, y), ...slope(this.#drawn, x, y), ...curve(this.#drawn, y), ...legend());
    this.#rows.replaceChildren(...this.#drawn.map(({ point }) => element("tr", {}, ...[
      duration(point.seconds), count(point.samples), scientific(point.relative_mse),
      hasBand(point) ? interval(point.low, point.high) : "–", scientific(point.mse),
    ].map((text) => element("td", {}, text)))));
  }

  #point(picture, event) {
    if (this.#drawn.length === 0) return;
    const box = picture.getBoundingClientRect();
    const at = ((event.clientX - box.left) / box.width) * WIDTH;
    const near = this.#drawn.reduce((a, b) => (Math.abs(b.x - at) < Math.abs(a.x - at) ? b : a));
    this.#marker.setAttribute("cx", near.x);
    this.#marker.setAttribute("cy", near.y);
    this.#marker.setAttribute("visibility", "visible");
    this.#say(near.point);
  }

  #leave() {
    this.#marker.setAttribute("visibility", "hidden");
    this.#say(this.#points.at(-1));
  }

  #say(point) {
    this.#readout.textContent = point === undefined ? "\u00a0"
      : `${count(point.samples)} samples, ${duration(point.seconds)}: relMSE ${scientific(point.relative_mse)}`
        + (hasBand(point) ? ` (95%: ${interval(point.low, point.high)})` : "");
  }
}

function isDrawable(point) {
  return point.seconds > 0 && point.relative_mse > 0 && Number.isFinite(point.relative_mse);
}

function hasBand(point) {
  return Number.isFinite(point.low) && Number.isFinite(point.high) && point.high > 0;
}

/** A logarithmic axis over whole decades where it can be, at least one decade long. */
function axis(values, from, to) {
  let low = Math.log10(Math.min(...values));
  let high = Math.log10(Math.max(...values));
  const missing = Math.max(0, 1 - (high - low)) / 2;
  low = Math.floor((low - missing) * 10 - 0.5) / 10;
  high = Math.ceil((high + missing) * 10 + 0.5) / 10;
  const decades = [];
  for (let exponent = Math.ceil(low); exponent <= high; exponent += 1) decades.push(exponent);
  const at = (value) => from + ((Math.max(Math.log10(value), low) - low) / (high - low)) * (to - from);
  return { low, high, decades, at, scale: Math.abs(to - from) / (high - low) };
}

function frame(x, y) {
  const [left, right] = [MARGIN.left, WIDTH - MARGIN.right];
  const [top, bottom] = [MARGIN.top, HEIGHT - MARGIN.bottom];
  const parts = [];
  for (const { value, label } of ticks(x, 5)) {
    const at = x.at(value);
    parts.push(svg("line", { class: "curve-grid", x1: at, x2: at, y1: top, y2: bottom }));
    parts.push(svg("text", { x: at, y: bottom + 16, "text-anchor": "middle" }, label));
  }
  for (const { value, label } of ticks(y, 7)) {
    const at = y.at(value);
    parts.push(svg("line", { class: "curve-grid", x1: left, x2: right, y1: at, y2: at }));
    parts.push(svg("text", { x: left - 8, y: at + 4, "text-anchor": "end" }, label));
  }
  parts.push(svg("rect", { class: "curve-frame", x: left, y: top, width: right - left, height: bottom - top }));
  parts.push(svg("text", { class: "curve-title", x: (left + right) / 2, y: HEIGHT - 6, "text-anchor": "middle" },
    "Render time (seconds)"));
  parts.push(svg("text", {
    class: "curve-title", "text-anchor": "middle", transform: `translate(11 ${(top + bottom) / 2}) rotate(-90)`,
  }, "Relative MSE"));
  return parts;
}

/** Decades, thinned to `most`; where fewer than two are in sight, 2 and 5 times them as well. */
function ticks({ low, high, decades }, most) {
  const every = Math.ceil(decades.length / most);
  if (decades.length > 1) {
    return decades.filter((_, index) => index % every === 0).map((e) => ({ value: 10 ** e, label: power(e) }));
  }
  const found = [];
  for (let exponent = Math.floor(low); exponent <= high; exponent += 1) {
    for (const digit of [1, 2, 5]) {
      const at = exponent + Math.log10(digit);
      if (at >= low && at <= high) {
        found.push({ value: digit * 10 ** exponent, label: digit === 1 ? power(exponent) : `${digit}·${power(exponent)}` });
      }
    }
  }
  return found;
}

/** Error falls as 1 / time for independent samples; drawn through the last point, for comparison. */
function slope(drawn, x, y) {
  const last = drawn.at(-1);
  const back = Math.min(last.x - MARGIN.left, ((last.y - MARGIN.top) / y.scale) * x.scale);
  if (drawn.length < 2 || back <= 0) return [];
  const start = { x: last.x - back, y: last.y - (back / x.scale) * y.scale };
  return [svg("path", { class: "curve-slope", d: `M${start.x} ${start.y}L${last.x} ${last.y}` })];
}

/** At the top right, which a falling curve leaves empty. */
function legend() {
  const right = WIDTH - MARGIN.right - 8;
  const rows = [
    ["estimate", (y) => svg("path", { class: "curve-line", d: `M${right - 22} ${y}h22` })],
    ["95% interval", (y) => svg("rect", { class: "curve-band", x: right - 22, y: y - 5, width: 22, height: 10 })],
    ["slope −1", (y) => svg("path", { class: "curve-slope", d: `M${right - 22} ${y}h22` })],
  ];
  return rows.flatMap(([label, sign], index) => {
    const y = MARGIN.top + 14 + 17 * index;
    return [sign(y), svg("text", { x: right - 30, y: y + 4, "text-anchor": "end" }, label)];
  });
}

function curve(drawn, y) {
  const parts = [];
  const band = drawn.filter(({ point }) => hasBand(point));
  if (band.length > 1) {
    const upper = band.map(({ x, point }) => `${x} ${y.at(point.high)}`);
    const lower = band.map(({ x, point }) => `${x} ${y.at(Math.max(point.low, 0))}`).reverse();
    parts.push(svg("path", { class: "curve-band", d: `M${[...upper, ...lower].join("L")}Z` }));
  }
  parts.push(svg("path", { class: "curve-line", d: `M${drawn.map(({ x, y: at }) => `${x} ${at}`).join("L")}` }));
  if (drawn.length <= 40) {
    parts.push(...drawn.map(({ x, y: at }) => svg("circle", { class: "curve-point", cx: x, cy: at, r: 3 })));
  }
  return parts;
}

/** Leaves out points that would lie on top of the one before; the last one always stays. */
function thin(drawn) {
  const kept = [];
  drawn.forEach((item, index) => {
    const before = kept.at(-1);
    const apart = before === undefined || Math.hypot(item.x - before.x, item.y - before.y) >= THINNEST;
    if (apart || index === drawn.length - 1) kept.push(item);
  });
  return kept;
}
