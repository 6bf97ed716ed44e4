/** The list of jobs, newest first, kept up to date while it is shown. */

import { listJobs, Unreachable } from "./api.js";
import { element, setText } from "./dom.js";
import { count, duration, percent, scientific, when } from "./format.js";
import { poll } from "./poll.js";
import { hasEnded, stateLabel, STATES } from "./states.js";

const BUSY = 2000; // milliseconds between two readings while something renders
const IDLE = 3000;
const PAGE = 50;

export function showList(container, { signal }) {
  const rows = new Map(); // id -> row, for what is on the page and nothing else
  let pages = 1;

  const list = element("ul", { class: "jobs", "aria-label": "Jobs" });
  const empty = element("div", { class: "empty", hidden: true });
  const fault = element("p", { class: "notice fault", role: "alert", hidden: true });
  const filter = element("select", { id: "filter", onchange: () => { pages = 1; reading.soon(); } },
    element("option", { value: "" }, "All states"), ...STATES.map((state) => element("option", { value: state }, state)));
  const more = element("button", { type: "button", hidden: true, onclick: () => { pages += 1; reading.soon(); } }, "Show more");
  container.append(
    element("div", { class: "heading" }, element("h1", {}, "Jobs"),
      element("label", { class: "quiet", for: "filter" }, "Show ", filter),
      element("a", { class: "button primary", href: "#/new" }, "New render")),
    fault, list, empty, more);

  async function read() {
    const jobs = [];
    let next = null;
    try {
      for (let page = 0; page < pages; page += 1) {
        const answer = await listJobs({ state: filter.value, after: next, limit: PAGE, signal });
        jobs.push(...answer.jobs);
        next = answer.next;
        if (!next) break;
      }
    } catch (error) {
      if (signal.aborted) return;
      fault.hidden = error instanceof Unreachable; // the banner tells of that
      setText(fault, fault.hidden ? "" : error.message);
      return;
    }
    fault.hidden = true;
    show(jobs, next);
  }

  function show(jobs, next) {
    const seen = new Set();
    let place = list.firstElementChild;
    for (const job of jobs) {
      if (seen.has(job.id)) continue; // a job may slip to the next page while they are read
      seen.add(job.id);
      if (!rows.has(job.id)) rows.set(job.id, makeRow(job));
      const row = rows.get(job.id);
      row.set(job);
      if (row.element === place) place = place.nextElementSibling;
      else list.insertBefore(row.element, place);
    }
    for (const [id, row] of rows) {
      if (seen.has(id)) continue;
      row.element.remove();
      rows.delete(id);
    }
    more.hidden = !next;
    empty.hidden = jobs.length > 0;
    if (jobs.length === 0) {
      empty.replaceChildren(filter.value ? element("p", {}, `No job is ${filter.value}.`)
        : element("p", {}, "No jobs yet. ", element("a", { href: "#/new" }, "Render an example scene")));
    }
  }

  const busy = () => Array.from(rows.values()).some((row) => !hasEnded(row.state));
  const reading = poll(read, { pause: () => (busy() ? BUSY : IDLE), least: 0, signal });
}

function makeRow(job) {
  const image = element("img", { alt: "", loading: "lazy", width: 96, height: 72, class: "absent",
    onload: () => image.classList.remove("absent"), onerror: () => image.classList.add("absent") });
  const state = stateLabel();
  const name = element("span", { class: "job-name" });
  const facts = element("span", { class: "quiet" });
  const progress = element("progress", { max: 1, "aria-label": "Progress" });
  const left = element("span", { class: "quiet job-left" });
  const error = element("span", { class: "job-error" });
  const row = {
    element: element("li", {}, element("a", { class: "job", href: `#/jobs/${encodeURIComponent(job.id)}` },
      element("span", { class: "job-picture" }, image),
      element("span", { class: "job-main" }, name, facts),
      element("span", { class: "job-state" }, state.element, error),
      element("span", { class: "job-progress" }, progress, left))),
    state: job.state,
    set(now) {
      row.state = now.state;
      state.set(now.state);
      setText(name, now.name || now.id);
      setText(facts, `${now.width} × ${now.height} · ${count(now.samples)} samples · ${when(now.created)}`);
      progress.value = now.progress;
      progress.hidden = hasEnded(now.state);
      setText(left, leftOf(now));
      setText(error, errorOf(now));
      // The address changes with the picture, so the browser's cache holds each picture once.
      const version = `${now.links.thumbnail}?at=${now.progress >= 1 ? now.state : now.progress.toFixed(2)}`;
      if (now.progress > 0 && image.getAttribute("src") !== version) image.src = version;
    },
  };
  return row;
}

function leftOf(job) {
  if (job.state === "done") return job.started && job.finished
    ? `took ${duration((Date.parse(job.finished) - Date.parse(job.started)) / 1000)}` : "";
  if (hasEnded(job.state)) return `at ${percent(job.progress)}`;
  if (job.state === "running" && job.seconds_left !== null) return `${percent(job.progress)} · ${duration(job.seconds_left)} left`;
  return percent(job.progress);
}

function errorOf(job) {
  if (job.state === "failed" && job.error) return job.error.message;
  return job.relative_mse > 0 ? `relMSE ${scientific(job.relative_mse)}` : "";
}
