/** One job: its picture as the tiles come in, its error against run time, its figures. */

import { actionBar } from "./actions.js";
import { eventsUrl, getCurve, getJob, getStatistics, getTiles, Unreachable } from "./api.js";
import { CurveChart } from "./curve.js";
import { element, setText } from "./dom.js";
import { follow } from "./events.js";
import { count, duration, percent, scientific, when } from "./format.js";
import { poll } from "./poll.js";
import { hasEnded, stateLabel } from "./states.js";
import { statisticsTable } from "./statistics.js";
import { Viewer } from "./viewer.js";
import { viewerControls } from "./viewer-controls.js";

const LIVE = 3000; // milliseconds between two readings of the job while it is under way
const ENDED = 15000; // someone else may retry it
const READABLE = 5000; // milliseconds for which it stays that an action was refused, whatever is read meanwhile
const QUIET = 20000; // an event stream without a word for so long, while the job moves on, is dead

export function showJob(container, { id, signal }) {
  const fault = element("p", { class: "notice fault", role: "alert", hidden: true });
  const parts = makeHeader(id, { onFault: refused, onDone: agreed });
  container.append(parts.element, fault);

  let viewer = null;
  let job = null;
  let gone = false;
  let stream = null;
  let refusedAt = -Infinity;
  let heard = performance.now(); // when the stream last said anything
  const chart = new CurveChart(signal);
  const statistics = statisticsTable();

  function tell(error) {
    if (signal.aborted) return;
    fault.hidden = error === null || error instanceof Unreachable; // the banner tells of that
    if (fault.hidden) setText(fault, "");
    else setText(fault, error.status === 404 ? "There is no such job. It may have been deleted." : error.message);
  }

  function refused(error) {
    refusedAt = performance.now();
    tell(error);
  }

  function agreed(deleted) {
    refusedAt = -Infinity;
    if (deleted) location.hash = "#/";
    else reading.soon();
  }

  /** Someone has deleted it, or it never was. */
  function letGo() {
    gone = true;
    stream?.close();
    stream = null;
    viewer?.stop();
    parts.letGo();
  }

  /** Reads the job itself; what hangs on a change of state follows from there. */
  async function read() {
    try {
      const before = job;
      job = await getJob(id, signal);
      if (performance.now() - refusedAt > READABLE) tell(null);
      if (viewer === null) build();
      parts.set(job);
      if (before && before.state !== job.state) await resync();
      const moved = before !== null && before.progress !== job.progress;
      if (hasEnded(job.state)) {
        stream?.close();
        stream = null;
      } else if (stream === null) {
        listen();
      } else if (moved && performance.now() - heard > QUIET) {
        heard = performance.now();
        stream.reopen();
      }
    } catch (error) {
      tell(error);
      if (error.status === 404) letGo();
    }
  }

  function build() {
    viewer = new Viewer(job, signal);
    container.append(element("div", { class: "columns" },
      element("section", { class: "picture", "aria-label": "Picture" },
        element("div", { class: "stage" }, viewer.canvas), viewerControls(viewer, job)),
      element("div", { class: "side" },
        element("section", { "aria-labelledby": "curve-title" },
          element("h2", { id: "curve-title" }, "Error against run time"), chart.element),
        element("section", { "aria-labelledby": "statistics-title" },
          element("h2", { id: "statistics-title" }, "Statistics"), statistics.element))));
    resync();
  }

  function listen() {
    heard = performance.now();
    stream = follow(eventsUrl(id), {
      signal,
      onOpen: resync,
      onLost: () => reading.soon(),
      onEvent(type, data) {
        heard = performance.now();
        if (type === "tile") viewer.tileChanged(data);
        if (type === "error") {
          chart.add(data);
          readStatistics();
        }
        reading.soon();
      },
    });
  }

  /** Tiles, curve and statistics as the server has them: at the start, after a gap, at a change of state. */
  async function resync() {
    await Promise.all([
      part(getTiles, ({ tiles }) => viewer.setTiles(tiles)),
      part(getCurve, ({ curve }) => chart.set(curve)),
      readStatistics(),
    ]);
    viewer.canvas.setAttribute("aria-label", `The picture, ${job.width} by ${job.height} pixels, ${job.state}`);
  }

  function readStatistics() {
    return part(getStatistics, (figures) => statistics.set(figures));
  }

  async function part(get, use) {
    try {
      const answer = await get(id, signal);
      if (!signal.aborted && !gone) use(answer);
    } catch (error) {
      // 404 and 409: there is none yet, as the statistics of a job that has not begun.
      if (![404, 409].includes(error.status)) tell(error);
    }
  }

  const reading = poll(read, { pause: () => (gone ? Infinity : job && hasEnded(job.state) ? ENDED : LIVE), signal });
}

/** The lines above the picture: {element, set(job), letGo()}. */
function makeHeader(id, handlers) {
  const title = element("h1", {}, "Job");
  const state = stateLabel();
  const actions = actionBar(id, handlers);
  const progress = element("progress", { max: 1, "aria-label": "Progress" });
  const status = element("span", { class: "status" });
  const facts = element("p", { class: "quiet facts" });
  const failure = element("p", { class: "notice fault", hidden: true });
  const announcement = element("p", { class: "unseen", role: "status" });
  return {
    element: element("div", { class: "job-header" },
      element("div", { class: "heading" }, title, state.element, actions.element),
      element("div", { class: "progress-line" }, progress, status), facts, failure, announcement),
    set(job) {
      setText(title, job.name || job.id);
      document.title = `${job.state === "running" ? `${percent(job.progress)} · ` : ""}${job.name || job.id} · Tilecast`;
      state.set(job.state);
      actions.set(job.state);
      progress.value = job.progress;
      setText(status, statusOf(job));
      setText(facts, `${job.width} × ${job.height} pixels · ${count(job.samples)} samples a pixel · sent ${when(job.created)}`);
      failure.hidden = !job.error;
      if (job.error) setText(failure, job.error.path ? `${job.error.path}: ${job.error.message}` : job.error.message);
      setText(announcement, `The job is ${job.state}.`);
    },
    letGo() {
      state.set("deleted");
      actions.element.hidden = true;
    },
  };
}

function statusOf(job) {
  const parts = [percent(job.progress)];
  if (job.state === "running" && job.seconds_left !== null) parts.push(`${duration(job.seconds_left)} left`);
  if (job.state === "done" && job.started && job.finished) {
    parts.push(`took ${duration((Date.parse(job.finished) - Date.parse(job.started)) / 1000)}`);
  }
  if (job.relative_mse > 0) parts.push(`relMSE ${scientific(job.relative_mse)}`);
  return parts.join(" · ");
}
