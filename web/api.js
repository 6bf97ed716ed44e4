/** The HTTP interface. Every failure is a Problem (the server refused) or Unreachable (no answer came). */

import { wrappedScene } from "./json-places.js";

/** An answer that refuses, as application/problem+json tells it. */
export class Problem extends Error {
  /** errors: [{path, message}], the places in the scene; empty where the problem has none. */
  constructor(status, title, detail, errors) {
    super(detail || title || `The server answered ${status}.`);
    this.status = status;
    this.title = title;
    this.errors = errors;
  }
}

/** No answer: the server is down, restarting or out of reach. */
export class Unreachable extends Error {}

/** Fires "change" when the server stops or starts answering; `reachable` says which. */
export const connection = new (class extends EventTarget {
  reachable = true;

  set(reachable) {
    if (this.reachable === reachable) return;
    this.reachable = reachable;
    this.dispatchEvent(new Event("change"));
  }
})();

const GATEWAY = new Set([502, 503, 504]);

async function call(path, { method = "GET", body, headers = {}, signal } = {}) {
  let response;
  try {
    response = await fetch(path, { method, body, headers, signal, cache: method === "GET" ? "no-cache" : "default" });
  } catch (error) {
    if (error.name === "AbortError") throw error;
    connection.set(false);
    throw new Unreachable("The server does not answer.", { cause: error });
  }
  if (GATEWAY.has(response.status) && !isProblem(response)) {
    connection.set(false);
    throw new Unreachable(`The server does not answer (${response.status}).`);
  }
  connection.set(true);
  if (!response.ok) throw await problem(response);
  return response;
}

function isProblem(response) {
  return (response.headers.get("content-type") ?? "").startsWith("application/problem+json");
}

async function problem(response) {
  let document = {};
  try {
    document = await response.json();
  } catch {
    // Not JSON: something between here and the server answered. The status says enough.
  }
  const errors = Array.isArray(document.errors) ? document.errors.map(({ path, message }) => ({
    path: String(path ?? ""), message: String(message ?? ""),
  })) : [];
  let detail = document.detail;
  const wait = response.headers.get("retry-after");
  if (response.status === 429 && wait) detail = `${detail || "Too many jobs."} Try again in ${wait} s.`;
  return new Problem(response.status, document.title, detail, errors);
}

async function json(path, options) {
  const response = await call(path, options);
  return response.status === 204 ? null : response.json();
}

const job = (id) => `/v1/jobs/${encodeURIComponent(id)}`;
const JSON_BODY = { "content-type": "application/json" };

/** One page of jobs, newest first: {jobs, next}. */
export function listJobs({ state, after, limit = 50, signal } = {}) {
  const query = new URLSearchParams({ limit });
  if (state) query.set("state", state);
  if (after) query.set("after", after);
  return json(`/v1/jobs?${query}`, { signal });
}

export const getJob = (id, signal) => json(job(id), { signal });
export const getTiles = (id, signal) => json(`${job(id)}/tiles`, { signal });
export const getCurve = (id, signal) => json(`${job(id)}/curve`, { signal });
export const getStatistics = (id, signal) => json(`${job(id)}/stats`, { signal });
export const listScenes = (signal) => json("/v1/scenes", { signal });
export const eventsUrl = (id) => `${job(id)}/events`;

/** The text of an example scene, as it was written. */
export async function getSceneText(name, signal) {
  return (await call(`/v1/scenes/${encodeURIComponent(name)}`, { signal })).text();
}

/** One tile as it stands: linear RGB half floats, [height, width, 3], row by row. */
export async function getTile(id, column, row, signal) {
  const response = await call(`${job(id)}/tiles/${column}/${row}.f16`, { signal });
  return new Uint16Array(await response.arrayBuffer());
}

/**
 * Submits a scene; `text` is its JSON as typed, so that what the server reads is what the user wrote. It may hold the
 * scene under "scene", with fields of its own, which give way to those here.
 * key: names this request; should its answer be lost, the same sent again makes no second job.
 */
export function submit(text, { name, priority, key, signal }) {
  const place = wrappedScene(text);
  const fields = place ? JSON.parse(text) : {};
  delete fields.scene;
  if (name) fields.name = name;
  if (priority) fields.priority = priority;
  const others = JSON.stringify(fields).slice(1, -1);
  const body = `{"scene":${place ? text.slice(place.start, place.end) : text}${others && `,${others}`}}`;
  return json("/v1/jobs", { method: "POST", body, headers: { ...JSON_BODY, "idempotency-key": key }, signal });
}

export const change = (id, fields) =>
  json(job(id), { method: "PATCH", body: JSON.stringify(fields), headers: JSON_BODY });
export const retry = (id) => json(`${job(id)}/retry`, { method: "POST" });

/** Cancels a job that is under way; deletes one that has ended. */
export const remove = (id) => json(job(id), { method: "DELETE" });

/** A key for submit(): 128 random bits. */
export function newKey() {
  const values = crypto.getRandomValues(new Uint8Array(16));
  return Array.from(values, (value) => value.toString(16).padStart(2, "0")).join("");
}
