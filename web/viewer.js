/** The picture of one job: fetches its tiles as they change and develops them on a canvas. */

import { getTile } from "./api.js";
import { toneTable } from "./half.js";

const MOST_FETCHES = 4;
const STRIPE = 256; // rows developed at once, to bound the memory
const MOST_PIXELS = 16e6; // of the canvas; a larger image is shown every second, third, ... pixel
const PAUSE_AFTER_FAILURE = 2000; // milliseconds

export class Viewer {
  #job;
  #signal;
  #context;
  #step; // image pixels to a canvas pixel, each way
  #light; // linear half floats of the canvas, [height, width, 3]
  #known = new Uint8Array(0); // 1 where a canvas pixel has a sample
  #versions = new Map(); // "column/row" -> the version shown
  #wanted = new Map(); // "column/row" -> the newest tile announced and not yet shown
  #fetching = 0;
  #beginning = 0; // counts the times that the job began anew
  #table = toneTable(0, "clip");
  #frame = 0;
  #timer = 0;

  /** job: {id, width, height}; signal: aborts when the page turns away. */
  constructor(job, signal) {
    this.#job = job;
    this.#signal = signal;
    this.#step = Math.max(1, Math.ceil(Math.sqrt((job.width * job.height) / MOST_PIXELS)));
    this.canvas = document.createElement("canvas");
    this.canvas.width = Math.ceil(job.width / this.#step);
    this.canvas.height = Math.ceil(job.height / this.#step);
    this.canvas.setAttribute("role", "img");
    this.#context = this.canvas.getContext("2d");
    this.#clear();
    signal.addEventListener("abort", () => this.#release(), { once: true });
  }

  /** Tiles that the canvas shows, at whatever version. */
  get shown() {
    return this.#versions.size;
  }

  /** The whole list as the server has it. A version below ours means that the job began anew. */
  setTiles(tiles) {
    const anew = tiles.some((tile) => tile.version < (this.#versions.get(key(tile)) ?? 0));
    if (anew) this.#clear();
    for (const tile of tiles) this.tileChanged(tile);
  }

  /** One tile has a new version. Tiles that change faster than they can be fetched skip versions. */
  tileChanged(tile) {
    const name = key(tile);
    if (tile.version <= (this.#versions.get(name) ?? 0)) return;
    if (tile.version <= (this.#wanted.get(name)?.version ?? 0)) return;
    this.#wanted.set(name, tile);
    this.#pump();
  }

  /** Asks for nothing more, as the job is gone. What is shown stays. */
  stop() {
    clearTimeout(this.#timer);
    this.#wanted.clear();
  }

  /** exposure: stops; operator: "clip" (as image.png) or "compress". */
  setTone(exposure, operator) {
    this.#table = toneTable(exposure, operator);
    if (this.#frame) return;
    this.#frame = requestAnimationFrame(() => {
      this.#frame = 0;
      const { width, height } = this.canvas;
      for (let y = 0; y < height; y += STRIPE) this.#develop(0, y, width, Math.min(STRIPE, height - y));
    });
  }

  #clear() {
    const { width, height } = this.canvas;
    this.#beginning += 1;
    this.#light = new Uint16Array(width * height * 3);
    this.#known = new Uint8Array(width * height);
    this.#versions.clear();
    this.#wanted.clear();
    this.#context.clearRect(0, 0, width, height);
  }

  #release() {
    cancelAnimationFrame(this.#frame);
    clearTimeout(this.#timer);
    this.#wanted.clear();
    this.#versions.clear();
    this.#light = new Uint16Array(0);
    // Safari keeps a canvas's memory until it is resized, however unreachable the element is.
    this.canvas.width = 0;
    this.canvas.height = 0;
  }

  #pump() {
    clearTimeout(this.#timer);
    for (const [name, tile] of this.#wanted) {
      if (this.#fetching >= MOST_FETCHES) return;
      this.#wanted.delete(name);
      this.#fetch(name, tile);
    }
  }

  async #fetch(name, tile) {
    this.#fetching += 1;
    const beginning = this.#beginning;
    let pause = 0;
    try {
      const values = await getTile(this.#job.id, tile.column, tile.row, this.#signal);
      if (values.length !== tile.width * tile.height * 3) throw new Error(`tile ${name}: ${values.length} values`);
      if (beginning === this.#beginning && tile.version > (this.#versions.get(name) ?? 0)) {
        this.#versions.set(name, tile.version);
        this.#place(tile, values);
      }
    } catch (error) {
      if (this.#signal.aborted) return;
      // Kept for later, unless a newer version has been announced in the meantime or the tile is no more.
      if (!this.#wanted.has(name) && error.status !== 404) this.#wanted.set(name, tile);
      pause = PAUSE_AFTER_FAILURE;
    } finally {
      this.#fetching -= 1;
    }
    if (pause) this.#timer = setTimeout(() => this.#pump(), pause);
    else this.#pump();
  }

  /** Copies a tile's light onto the canvas's grid and develops it. */
  #place(tile, values) {
    const step = this.#step;
    const width = this.canvas.width;
    const [left, top] = [Math.ceil(tile.x / step), Math.ceil(tile.y / step)];
    const right = Math.ceil((tile.x + tile.width) / step);
    const bottom = Math.ceil((tile.y + tile.height) / step);
    for (let y = top; y < bottom; y += 1) {
      const row = (y * step - tile.y) * tile.width;
      for (let x = left; x < right; x += 1) {
        const from = (row + x * step - tile.x) * 3;
        const to = y * width + x;
        this.#light[3 * to] = values[from];
        this.#light[3 * to + 1] = values[from + 1];
        this.#light[3 * to + 2] = values[from + 2];
        this.#known[to] = 1;
      }
    }
    this.#develop(left, top, right - left, bottom - top);
  }

  /** Light to pixels, for a rectangle of the canvas. */
  #develop(left, top, width, height) {
    if (width <= 0 || height <= 0) return;
    const image = this.#context.createImageData(width, height);
    const table = this.#table;
    for (let y = 0, to = 0; y < height; y += 1) {
      let from = (top + y) * this.canvas.width + left;
      for (let x = 0; x < width; x += 1, from += 1, to += 4) {
        image.data[to] = table[this.#light[3 * from]];
        image.data[to + 1] = table[this.#light[3 * from + 1]];
        image.data[to + 2] = table[this.#light[3 * from + 2]];
        image.data[to + 3] = this.#known[from] * 255;
      }
    }
    this.#context.putImageData(image, left, top);
  }
}

function key(tile) {
  return `${tile.column}/${tile.row}`;
}
