/**
 * Elements from data. Text always enters as text nodes, so nothing that comes from a scene or the server
 * can become markup.
 */

const SVG = "http://www.w3.org/2000/svg";

/**
 * Makes an HTML element: element("button", {type: "button", onclick: start}, "Start").
 * Attributes: functions become listeners ("onclick"), true and false set or leave out, the rest are strings.
 * Children: nodes, strings, numbers; null and false are left out.
 */
export function element(tag, attributes = {}, ...children) {
  return fill(document.createElement(tag), attributes, children);
}

/** The same for SVG. */
export function svg(tag, attributes = {}, ...children) {
  return fill(document.createElementNS(SVG, tag), attributes, children);
}

function fill(node, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === "function") node.addEventListener(name.slice(2), value);
    else if (value === true) node.setAttribute(name, "");
    else if (value !== false && value !== null && value !== undefined) node.setAttribute(name, value);
  }
  node.append(...children.filter((child) => child !== null && child !== false && child !== undefined));
  return node;
}

/** Sets text only where it differs, so that a selection, or a screen reader, is not disturbed by a refresh. */
export function setText(node, text) {
  if (node.textContent !== text) node.textContent = text;
}
