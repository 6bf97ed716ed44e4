/**
 * Where things stand in a JSON text: the place of a syntax error, and the place of a value named by a path
 * such as "objects.lens.of[1].radius". JSON.parse tells neither in a way that is the same in all browsers.
 */

const DEEPEST = 64; // as the server
const NUMBER = /-?(?:0|[1-9]\d*)(?:\.\d+)?(?:[eE][+-]?\d+)?/y;
const STRING = /"(?:[^"\\\u0000-\u001f]|\\(?:["\\/bfnrt]|u[0-9a-fA-F]{4}))*"/y;
const PART = /\[("(?:[^"\\]|\\.)*")\]|[^.[\]]+/g; // of a path; keys that are no plain words stand in quotes
const WORD = /[A-Za-z_$][\w$]*/y;

class SyntaxProblem extends Error {
  constructor(message, offset) {
    super(message);
    this.offset = offset;
  }
}

/** null for a JSON text, otherwise {message, offset}. */
export function findSyntaxError(text) {
  try {
    walk(text, () => {});
    return null;
  } catch (error) {
    if (error instanceof SyntaxProblem) return { message: error.message, offset: error.offset };
    throw error;
  }
}

/**
 * {start, end} of the value at `path`, or of the innermost value on the way to it that is there (a missing
 * key is an error of the object that lacks it). null if the text is not JSON.
 */
export function locate(text, path) {
  const wanted = Array.from(path.matchAll(PART), ([part, quoted]) => (quoted === undefined ? part : JSON.parse(quoted)));
  let best = null;
  let depth = -1;
  try {
    walk(text, (segments, start, end) => {
      if (segments.length <= depth || segments.length > wanted.length) return;
      if (segments.every((segment, index) => String(segment) === wanted[index])) {
        best = { start, end };
        depth = segments.length;
      }
    });
  } catch (error) {
    if (error instanceof SyntaxProblem) return null;
    throw error;
  }
  return best;
}

/** {start, end} of the scene in a JSON text that holds it under "scene"; null for a bare scene, which has a list there. */
export function wrappedScene(text) {
  const place = locate(text, "scene");
  return place && place.start > text.search(/\S/) && text[place.start] === "{" ? place : null;
}

/** Line and column of an offset, from 1. */
export function lineAndColumn(text, offset) {
  const before = text.slice(0, offset);
  return { line: before.split("\n").length, column: offset - before.lastIndexOf("\n") };
}

/** Reads the whole text; visit(segments, start, end) runs for every value, inner ones first. */
function walk(text, visit) {
  let at = 0;
  const segments = [];

  function fail(message, offset = at) {
    throw new SyntaxProblem(message, offset);
  }

  function space() {
    while (at < text.length && " \t\n\r".includes(text[at])) at += 1;
  }

  function found() {
    if (at >= text.length) return "the end of the text";
    return `${JSON.stringify(text[at])}`;
  }

  function match(pattern) {
    pattern.lastIndex = at;
    const [token] = pattern.exec(text) ?? [null];
    if (token !== null) at += token.length;
    return token;
  }

  function string(what) {
    if (text[at] !== '"') fail(`expected ${what}, found ${found()}`);
    const start = at;
    return match(STRING) ?? fail("this string does not end, or holds a line break or a bad escape", start);
  }

  function word() {
    const start = at;
    const token = match(WORD);
    if (token === "true" || token === "false" || token === "null") return;
    fail(token ? `${token} is not JSON` : `expected a value, found ${found()}`, start);
  }

  function value() {
    space();
    const start = at;
    if (segments.length > DEEPEST) fail(`nested deeper than ${DEEPEST}`);
    if (text[at] === "{") members("}", objectMember);
    else if (text[at] === "[") members("]", arrayMember);
    else if (text[at] === '"') string("a string");
    else if (match(NUMBER) === null) word();
    visit(segments, start, at);
  }

  function members(closing, member) {
    at += 1;
    space();
    if (text[at] === closing) {
      at += 1;
      return;
    }
    for (let index = 0; ; index += 1) {
      member(index);
      space();
      if (text[at] === closing) break;
      if (text[at] !== ",") fail(`expected a comma or ${closing}, found ${found()}`);
      const comma = at;
      at += 1;
      space();
      if (text[at] === closing) fail(`a comma before ${closing}`, comma);
    }
    at += 1;
  }

  function objectMember() {
    const key = JSON.parse(string("a key in double quotes"));
    space();
    if (text[at] !== ":") fail(`expected a colon, found ${found()}`);
    at += 1;
    descend(key);
  }

  function arrayMember(index) {
    descend(index);
  }

  function descend(segment) {
    segments.push(segment);
    value();
    segments.pop();
  }

  value();
  space();
  if (at < text.length) fail(`expected the end of the text, found ${found()}`);
}
