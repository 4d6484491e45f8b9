// A course drawn by a pointer: an event's friction from where the disk meets it to where it leaves
// it, and what the curve's intensity does to the bare surface. What is drawn is `points`, of the
// kind or of the preset; without any it is as it was before.

import { by } from "./dom.js";

/** @import { Drawing } from "../types" */

const COUNT = 33;
const WIDTH = 320;
const HEIGHT = 96;
const MOST_UNDONE = 50;

/** @type {Drawing} */
export const COURSE = {
  name: "Course",
  label: "friction over the event, to be drawn by a pointer",
  doc: "Drawn with a pointer, from where the disk meets the event to where it leaves it; it takes "
    + "the place of the shape.",
  back: "Back to its shape",
  plain: () => 0,
  empty: false, // a course of nothing would be no event
};

/** @type {Drawing} */
export const MAP = {
  name: "Intensity map",
  label: "friction over the curve's intensity, to be drawn by a pointer",
  doc: "Drawn with a pointer: from left to right the curve, from its lowest to its highest; upwards "
    + "how much of the ambience is felt there.",
  back: "Back to a straight line",
  plain: (part) => part,
  empty: true,
};

/**
 * @param {string} name
 * @param {Record<string, string>} attributes
 */
function svg(name, attributes) {
  const made = document.createElementNS(by("canvas").namespaceURI, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  return made;
}

/**
 * Where a pointer is on the drawing: which point, and how high (0 to 1).
 * @param {DOMRect} box
 * @param {PointerEvent} event
 * @returns {[number, number]}
 */
function placeOf(box, { clientX, clientY }) {
  const part = Math.min(Math.max((clientX - box.left) / box.width, 0), 1);
  const level = Math.min(Math.max(1 - (clientY - box.top) / box.height, 0), 1);
  return [Math.round(part * (COUNT - 1)), Number(level.toFixed(3))];
}

/**
 * Points at the places of a drawing, `plain` where nothing is drawn.
 * @param {number[]} points
 * @param {(part: number) => number} plain
 */
export function atPlaces(points, plain) {
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
 * Points with a straight line from one place to another drawn into them.
 * @param {number[]} points
 * @param {[number, number]} from
 * @param {[number, number]} to
 */
export function withLine(points, [from, before], [to, level]) {
  const drawn = points.map((point) => Number(point.toFixed(3)));
  const steps = Math.max(Math.abs(to - from), 1);
  for (let k = 0; k <= steps; k += 1) {
    const place = Math.round(from + ((to - from) * k) / steps);
    drawn[place] = Number((before + ((level - before) * k) / steps).toFixed(3));
  }
  return drawn;
}

/**
 * The row in which `owner.points` is drawn; `onchange()` follows each stroke of the pointer.
 * @param {{ points: number[] }} owner
 * @param {Drawing} what
 * @param {() => void} onchange
 */
export function drawingOf(owner, { name, label, doc, back, plain, empty }, onchange) {
  /** @type {number[][]} */
  const undone = [];
  const line = svg("polyline", { class: "course" });
  const pad = svg("svg", {
    viewBox: `0 0 ${WIDTH} ${HEIGHT}`, class: "drawing", role: "img",
    preserveAspectRatio: "none", "aria-label": label,
  });
  pad.append(line);
  /** @type {(text: string, act: () => void) => HTMLButtonElement} */
  const button = (text, act) => {
    const made = Object.assign(document.createElement("button"), { type: "button" });
    made.textContent = text;
    made.addEventListener("click", act);
    return made;
  };
  const show = () => {
    const points = atPlaces(owner.points, plain);
    const xy = points.map((level, k) => `${(k * WIDTH) / (COUNT - 1)},${HEIGHT * (1 - level)}`);
    line.setAttribute("points", owner.points.length > 0 || empty ? xy.join(" ") : "");
    line.classList.toggle("plain", owner.points.length === 0);
    undo.disabled = undone.length === 0;
    clear.disabled = owner.points.length === 0;
  };
  const keep = () => {
    undone.push([...owner.points]);
    if (undone.length > MOST_UNDONE) undone.shift();
  };
  /** @param {number[]} points */
  const become = (points) => {
    owner.points = empty || points.some((level) => level > 0) ? points : [];
    show();
    onchange();
  };
  const undo = button("Undo", () => become(undone.pop() ?? []));
  const clear = button(back, () => {
    keep();
    become([]);
  });
  /** @type {[number, number] | null} */
  let last = null;
  pad.addEventListener("pointerdown", (/** @type {PointerEvent} */ event) => {
    pad.setPointerCapture(event.pointerId);
    keep();
    last = placeOf(pad.getBoundingClientRect(), event);
    become(withLine(atPlaces(owner.points, plain), last, last));
  });
  pad.addEventListener("pointermove", (/** @type {PointerEvent} */ event) => {
    if (last === null) return;
    const next = placeOf(pad.getBoundingClientRect(), event);
    become(withLine(atPlaces(owner.points, plain), last, next));
    last = next;
  });
  for (const end of ["pointerup", "pointercancel"]) {
    pad.addEventListener(end, () => {
      last = null;
    });
  }
  const row = document.createElement("div");
  row.className = "parameter drawn";
  const title = document.createElement("span");
  title.textContent = name;
  const note = document.createElement("small");
  note.textContent = doc;
  const bar = document.createElement("div");
  bar.className = "bar";
  bar.append(undo, clear);
  row.append(title, pad, bar, note);
  show();
  return row;
}
