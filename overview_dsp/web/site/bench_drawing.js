// An event's friction drawn by hand: its course from where the disk meets it to where it leaves it.
// What is drawn is the preset's `points`, in place of its shape; without any, the shape is back.

const COUNT = 33;
const WIDTH = 320;
const HEIGHT = 96;
const MOST_UNDONE = 50;

function svg(name, attributes) {
  // the namespace of the page's own picture: no file of the page spells an address
  const namespace = document.querySelector("svg").namespaceURI;
  const made = /** @type {SVGElement} */ (document.createElementNS(namespace, name));
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  return made;
}

/**
 * Where a pointer is on the drawing: which point, and how high (0 to 1).
 * @returns {[number, number]}
 */
function placeOf(box, { clientX, clientY }) {
  const part = Math.min(Math.max((clientX - box.left) / box.width, 0), 1);
  const level = Math.min(Math.max(1 - (clientY - box.top) / box.height, 0), 1);
  return [Math.round(part * (COUNT - 1)), Number(level.toFixed(3))];
}

/** A course's points at the places of a drawing. */
function atPlaces(points) {
  return Array.from({ length: COUNT }, (_, k) => {
    if (points.length === 0) return 0;
    const at = (k / (COUNT - 1)) * (points.length - 1);
    const low = Math.floor(at);
    const high = Math.min(low + 1, points.length - 1);
    return points[low] + (points[high] - points[low]) * (at - low);
  });
}

/** Points with a straight line from one place to another drawn into them. */
function withLine(points, [from, before], [to, level]) {
  const drawn = [...points];
  const steps = Math.max(Math.abs(to - from), 1);
  for (let k = 0; k <= steps; k += 1) {
    const place = Math.round(from + ((to - from) * k) / steps);
    drawn[place] = Number((before + ((level - before) * k) / steps).toFixed(3));
  }
  return drawn;
}

/** The row in which `kind.points` is drawn; `onchange()` follows each stroke of the pointer. */
export function drawingOf(kind, onchange) {
  const undone = [];
  const line = svg("polyline", { class: "course" });
  const pad = svg("svg", {
    viewBox: `0 0 ${WIDTH} ${HEIGHT}`, class: "drawing", role: "img",
    preserveAspectRatio: "none", "aria-label": "friction over the event, to be drawn by a pointer",
  });
  pad.append(line);
  const button = (text, act) => {
    const made = Object.assign(document.createElement("button"), { type: "button" });
    made.textContent = text;
    made.addEventListener("click", act);
    return made;
  };
  const show = () => {
    const points = atPlaces(kind.points);
    const xy = points.map((level, k) => `${(k * WIDTH) / (COUNT - 1)},${HEIGHT * (1 - level)}`);
    line.setAttribute("points", kind.points.length > 0 ? xy.join(" ") : "");
    undo.disabled = undone.length === 0;
    clear.disabled = kind.points.length === 0;
  };
  const keep = () => {
    undone.push([...kind.points]);
    if (undone.length > MOST_UNDONE) undone.shift();
  };
  const become = (points) => {
    // a course of nothing would be no event
    kind.points = points.some((level) => level > 0) ? points : [];
    show();
    onchange();
  };
  const undo = button("Undo", () => become(undone.pop()));
  const clear = button("Back to its shape", () => {
    keep();
    become([]);
  });
  /** @type {[number, number] | null} */
  let last = null;
  pad.addEventListener("pointerdown", (event) => {
    pad.setPointerCapture(event.pointerId);
    keep();
    last = placeOf(pad.getBoundingClientRect(), event);
    become(withLine(atPlaces(kind.points), last, last));
  });
  pad.addEventListener("pointermove", (event) => {
    if (last === null) return;
    const next = placeOf(pad.getBoundingClientRect(), event);
    become(withLine(atPlaces(kind.points), last, next));
    last = next;
  });
  for (const end of ["pointerup", "pointercancel"]) {
    pad.addEventListener(end, () => {
      last = null;
    });
  }
  const row = document.createElement("div");
  row.className = "parameter drawn";
  const name = document.createElement("span");
  name.textContent = "Course";
  const doc = document.createElement("small");
  doc.textContent = "Drawn with a pointer, from where the disk meets the event to where it leaves "
    + "it; it takes the place of the shape.";
  const bar = document.createElement("div");
  bar.className = "bar";
  bar.append(undo, clear);
  row.append(name, pad, bar, doc);
  show();
  return row;
}
