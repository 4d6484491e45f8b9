// Curves that the user draws: an event's friction profile, and the mapping from intensity to friction.
// The drawn `points` belong to the event kind or the preset. Without points the defaults apply.

import { button, byId, made } from "./dom.js";

/** @import { Drawing } from "../types" */

const COUNT = 33;
const WIDTH = 320;
const HEIGHT = 96;
const MOST_EARLIER = 50;

/** @type {Drawing} */
export const PROFILE = {
  name: "Profile",
  label: "friction profile of the event, drawn by a pointer",
  doc: "Draw the friction from the start of the event to its end. It replaces the shape.",
  back: "Use the shape",
  plain: () => 0,
  empty: false, // a profile of zeros would remove the event
};

/** @type {Drawing} */
export const MAP = {
  name: "Intensity mapping",
  label: "friction over the intensity, drawn by a pointer",
  doc: "Draw the friction (upwards) over the intensity, from its lowest (left) to its highest value.",
  back: "Use a straight line",
  plain: (part) => part,
  empty: true,
};

/**
 * @param {string} name
 * @param {Record<string, string>} attributes
 */
function svg(name, attributes) {
  const element = /** @type {SVGElement} */ (document.createElementNS(byId("canvas").namespaceURI, name));
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  return element;
}

/**
 * Return the point under the pointer and its level (0 to 1).
 * @param {DOMRect} box
 * @param {PointerEvent} event
 * @returns {[number, number]}
 */
function pointAt(box, { clientX, clientY }) {
  const part = Math.min(Math.max((clientX - box.left) / box.width, 0), 1);
  const level = Math.min(Math.max(1 - (clientY - box.top) / box.height, 0), 1);
  return [Math.round(part * (COUNT - 1)), Number(level.toFixed(3))];
}

/**
 * Return the points resampled to the drawing; `plain` gives the levels without any points.
 * @param {number[]} points
 * @param {(part: number) => number} plain
 */
export function resampled(points, plain) {
  return Array.from({ length: COUNT }, (_, k) => {
    const part = k / (COUNT - 1);
    if (points.length === 0) return plain(part);
    const at = part * (points.length - 1);
    const low = Math.floor(at);
    const high = Math.min(low + 1, points.length - 1);
    return points[low] + (points[high] - points[low]) * (at - low);
  });
}

/**
 * Return points with a straight line drawn between two of them.
 * @param {number[]} points
 * @param {[number, number]} from
 * @param {[number, number]} to
 */
export function withLine(points, [from, before], [to, level]) {
  const drawn = points.map((point) => Number(point.toFixed(3)));
  const steps = Math.max(Math.abs(to - from), 1);
  for (let k = 0; k <= steps; k += 1) {
    const position = Math.round(from + ((to - from) * k) / steps);
    drawn[position] = Number((before + ((level - before) * k) / steps).toFixed(3));
  }
  return drawn;
}

/**
 * Return a row in which the user draws `owner.points`; `onchange()` is called after each change.
 * @param {{ points: number[] }} owner
 * @param {Drawing} what
 * @param {() => void} onchange
 */
export function drawingOf(owner, { name, label, doc, back, plain, empty }, onchange) {
  /** @type {number[][]} */
  const earlier = [];
  const line = svg("polyline", { class: "course" });
  const pad = svg("svg", {
    viewBox: `0 0 ${WIDTH} ${HEIGHT}`, class: "drawing", role: "img",
    preserveAspectRatio: "none", "aria-label": label,
  });
  pad.append(line);
  const show = () => {
    const points = resampled(owner.points, plain);
    const xy = points.map((level, k) => `${(k * WIDTH) / (COUNT - 1)},${HEIGHT * (1 - level)}`);
    line.setAttribute("points", owner.points.length > 0 || empty ? xy.join(" ") : "");
    line.classList.toggle("plain", owner.points.length === 0);
    undo.disabled = earlier.length === 0;
    clear.disabled = owner.points.length === 0;
  };
  const remember = () => {
    earlier.push([...owner.points]);
    if (earlier.length > MOST_EARLIER) earlier.shift();
  };
  /** @param {number[]} points */
  const setPoints = (points) => {
    owner.points = empty || points.some((level) => level > 0) ? points : [];
    show();
    onchange();
  };
  const undo = button("", () => setPoints(earlier.pop() ?? []), "Undo");
  const clear = button("", () => {
    remember();
    setPoints([]);
  }, back);
  /** @type {[number, number] | null} */
  let last = null;
  pad.addEventListener("pointerdown", (/** @type {PointerEvent} */ event) => {
    pad.setPointerCapture(event.pointerId);
    remember();
    last = pointAt(pad.getBoundingClientRect(), event);
    setPoints(withLine(resampled(owner.points, plain), last, last));
  });
  pad.addEventListener("pointermove", (/** @type {PointerEvent} */ event) => {
    if (last === null) return;
    const next = pointAt(pad.getBoundingClientRect(), event);
    setPoints(withLine(resampled(owner.points, plain), last, next));
    last = next;
  });
  for (const end of ["pointerup", "pointercancel"]) {
    pad.addEventListener(end, () => {
      last = null;
    });
  }
  show();
  return made("div", { className: "parameter drawn" }, made("span", {}, name), pad,
    made("div", { className: "bar" }, undo, clear), made("small", {}, doc));
}
