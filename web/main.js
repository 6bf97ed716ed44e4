/** The page: one view at a time, chosen by the address's hash. #/ · #/new · #/jobs/ID */

import { connection } from "./api.js";
import { element } from "./dom.js";
import { showJob } from "./job.js";
import { showList } from "./list.js";
import { showSubmit } from "./submit.js";

const main = document.getElementById("main");
const lost = document.getElementById("lost");
let view = new AbortController();

function route() {
  const [, place = "", id = ""] = location.hash.slice(1).split("/");
  if (place === "") return { show: showList, title: "Jobs", home: "#/" };
  if (place === "new") return { show: showSubmit, title: "New render", home: "#/new" };
  if (place === "jobs" && id) return { show: showJob, title: "Job", home: "#/", id: decode(id) };
  return { show: showNothing, title: "Not found", home: "" };
}

function decode(text) {
  try {
    return decodeURIComponent(text);
  } catch {
    return text; // a stray % in a typed address; the server will not know such a job
  }
}

function navigate(first) {
  view.abort(); // ends every request, timer, listener and stream of the view before
  view = new AbortController();
  const { show, title, home, id } = route();
  document.title = `${title} · Tilecast`;
  for (const link of document.querySelectorAll("nav a")) {
    if (link.getAttribute("href") === home) link.setAttribute("aria-current", "page");
    else link.removeAttribute("aria-current");
  }
  main.replaceChildren();
  if (!first) {
    window.scrollTo(0, 0);
    main.focus({ preventScroll: true }); // so that a keyboard or a screen reader goes on from the new view
  }
  show(main, { id, signal: view.signal });
}

function showNothing(container) {
  container.append(element("h1", {}, "Not found"),
    element("p", {}, "There is nothing at this address. ", element("a", { href: "#/" }, "All jobs")));
}

connection.addEventListener("change", () => {
  lost.hidden = connection.reachable;
});
document.querySelector(".skip").addEventListener("click", (event) => {
  event.preventDefault(); // the hash is the view's
  main.focus();
});
window.addEventListener("hashchange", () => navigate(false));
navigate(true);
