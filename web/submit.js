/** The box for a new scene: paste it, open a file or pick an example; what is wrong with it stands beside it. */

import { getSceneText, listScenes, newKey, submit, Unreachable } from "./api.js";
import { element } from "./dom.js";
import { findSyntaxError, lineAndColumn, locate, wrappedScene } from "./json-places.js";

const CHECK_AFTER = 400; // milliseconds without a key pressed
const DRAFT = "tilecast-draft"; // in the tab's storage

export function showSubmit(container, { signal }) {
  let timer = 0;
  let sent = { request: null, key: null }; // the last request, should its answer have been lost
  const box = element("textarea", { id: "scene", spellcheck: "false", autocomplete: "off", autocapitalize: "off", wrap: "off",
    "aria-describedby": "faults", placeholder: "Paste a scene, open a file, or pick an example", oninput: edited });
  const examples = element("select", { id: "example", onchange: pick }, element("option", { value: "" }, "Choose an example…"));
  const file = element("input", { id: "file", type: "file", accept: ".json,application/json", onchange: () => open(file.files[0]) });
  const name = element("input", { id: "name", type: "text", maxlength: 200, autocomplete: "off", placeholder: "Optional" });
  const priority = element("select", { id: "priority" },
    ...[["-1", "Low"], ["0", "Normal"], ["1", "High"]].map(([value, label]) => element("option", { value, selected: value === "0" }, label)));
  const faults = element("div", { id: "faults", class: "faults", role: "alert" });
  const send = element("button", { type: "submit", class: "primary" }, "Render");
  const form = element("form", { class: "submit", onsubmit: (event) => { event.preventDefault(); post(); } },
    element("div", { class: "controls" },
      element("span", { class: "pair" }, element("label", { for: "example" }, "Example"), examples),
      element("span", { class: "pair" }, element("label", { for: "file" }, "File"), file)),
    element("div", { class: "editor" },
      element("div", {}, element("label", { for: "scene" }, "Scene (JSON)"), box), faults),
    element("div", { class: "controls" },
      element("span", { class: "pair grows" }, element("label", { for: "name" }, "Name"), name),
      element("span", { class: "pair" }, element("label", { for: "priority" }, "Priority"), priority), send));
  container.append(element("div", { class: "heading" }, element("h1", {}, "New render")), form);

  box.addEventListener("dragover", (event) => event.preventDefault());
  box.addEventListener("drop", (event) => {
    const [dropped] = event.dataTransfer.files;
    if (!dropped) return; // text: the browser's own way of dropping it is right
    event.preventDefault();
    open(dropped);
  });
  signal.addEventListener("abort", () => { clearTimeout(timer); keep(); }, { once: true });
  window.addEventListener("pagehide", keep, { signal });
  restore();
  fillExamples();

  /** What was typed outlives a turn to another view, and a reload. */
  function keep() {
    try {
      sessionStorage.removeItem(DRAFT);
      sessionStorage.setItem(DRAFT, JSON.stringify({ text: box.value, name: name.value, priority: priority.value }));
    } catch {
      // Too large, or the browser allows no storage: it is as if nothing had been typed.
    }
  }

  function restore() {
    try {
      const draft = JSON.parse(sessionStorage.getItem(DRAFT));
      if (!draft?.text) return;
      priority.value = draft.priority;
      use(draft.text, draft.name);
    } catch {
      // As above.
    }
  }

  async function fillExamples() {
    try {
      const { scenes } = await listScenes(signal);
      examples.append(...scenes.map((scene) => element("option", { value: scene.name }, scene.title || scene.name)));
      examples.disabled = scenes.length === 0;
    } catch (error) {
      if (!signal.aborted) show([{ path: "", message: `The examples could not be listed: ${error.message}` }]);
    }
  }

  async function pick() {
    if (!examples.value) return;
    const chosen = examples.value;
    try {
      const text = await getSceneText(chosen, signal);
      if (examples.value === chosen) use(text, chosen);
    } catch (error) {
      if (!signal.aborted) show([{ path: "", message: error.message }]);
    }
  }

  async function open(chosen) {
    if (!chosen) return;
    const text = await chosen.text();
    if (!signal.aborted) use(text, chosen.name.replace(/\.json$/, ""));
    file.value = ""; // so that the same file can be opened again after it was edited
  }

  function use(text, title) {
    box.value = text;
    name.value = title;
    box.scrollTop = 0;
    check();
  }

  function edited() {
    clearTimeout(timer);
    timer = setTimeout(check, CHECK_AFTER);
  }

  /** Syntax alone: what the fields mean, the server knows. True if the text is JSON. */
  function check() {
    clearTimeout(timer);
    const text = box.value;
    const fault = text.trim() ? findSyntaxError(text) : null;
    if (fault === null) {
      show([]);
      return true;
    }
    const { line, column } = lineAndColumn(text, fault.offset);
    show([{ path: `line ${line}, column ${column}`, message: fault.message, start: fault.offset, end: fault.offset + 1 }]);
    return false;
  }

  async function post() {
    if (!box.value.trim()) {
      show([{ path: "", message: "There is no scene yet: paste one, or pick an example." }]);
      box.focus();
      return;
    }
    if (!check()) return;
    send.disabled = true;
    const fields = { name: name.value.trim(), priority: Number(priority.value) };
    const request = JSON.stringify([box.value, fields]);
    if (sent.request !== request) sent = { request, key: newKey() };
    try {
      const job = await submit(box.value, { ...fields, key: sent.key, signal });
      location.hash = `#/jobs/${encodeURIComponent(job.id)}`;
    } catch (error) {
      if (signal.aborted) return;
      if (!(error instanceof Unreachable)) sent.request = null; // answered: the next request is another one
      const errors = error.errors?.length ? error.errors : [{ path: "", message: error.message }];
      show(errors.map((each) => ({ ...each, ...(each.path ? find(each.path) : null) })));
    } finally {
      send.disabled = false;
    }
  }

  /** {start, end} of a place in the scene, or of one in what it is wrapped in. */
  function find(path) {
    const scene = wrappedScene(box.value);
    if (scene === null) return locate(box.value, path);
    const { start, end } = locate(box.value.slice(scene.start, scene.end), path);
    return { start: scene.start + start, end: scene.start + end };
  }

  /** errors: [{path, message, start?, end?}]; those with a place lead to it. */
  function show(errors) {
    box.setAttribute("aria-invalid", String(errors.length > 0));
    const items = errors.map(({ path, message, start, end }) => {
      const text = [path && element("code", {}, path), path && " ", message].filter(Boolean);
      return element("li", {}, start === undefined ? element("span", {}, ...text)
        : element("button", { type: "button", title: "Show the place", onclick: () => select(start, end) }, ...text));
    });
    faults.replaceChildren(...(items.length ? [element("h2", {}, "Not accepted"), element("ul", {}, ...items)] : []));
  }

  function select(start, end) {
    box.focus();
    box.setSelectionRange(start, end);
    const style = getComputedStyle(box);
    const { line } = lineAndColumn(box.value, start);
    box.scrollTop = (line - 1) * parseFloat(style.lineHeight) - box.clientHeight / 3;
  }
}
