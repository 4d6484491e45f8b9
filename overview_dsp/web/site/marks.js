// Marks of the event kinds, which differ in shape; colour and fill are the side: a team, rise or fall.

/** @import { Kind, Mark, PathContext } from "../types" */
/** @typedef {(path: PathContext, x: number, y: number, r: number) => void} Shape */

/** @type {(corners: number, turn?: number, inner?: number) => Shape} */
const polygon = (corners, turn = -Math.PI / 2, inner = 1) => (path, x, y, r) => {
  const count = inner === 1 ? corners : 2 * corners;
  for (let i = 0; i < count; i += 1) {
    const radius = i % 2 === 0 || inner === 1 ? r : r * inner;
    const angle = turn + (2 * Math.PI * i) / count;
    path.lineTo(x + radius * Math.cos(angle), y + radius * Math.sin(angle));
  }
  path.closePath();
};

/** @type {(...ends: [number, number, number, number][]) => Shape} */
const lines = (...ends) => (path, x, y, r) => {
  for (const [x1, y1, x2, y2] of ends) {
    path.moveTo(x + x1 * r, y + y1 * r);
    path.lineTo(x + x2 * r, y + y2 * r);
  }
};

const D = 0.75; // half width of cross and plus
/** @type {Record<string, Shape>} */
const SHAPES = {
  circle: (path, x, y, r) => path.arc(x, y, r, 0, 2 * Math.PI),
  hexagon: polygon(6),
  triangle: polygon(3),
  fall: polygon(3, Math.PI / 2),
  square: polygon(4, Math.PI / 4),
  card: (path, x, y, r) => {
    for (const [dx, dy] of [[-0.7, -1], [0.7, -1], [0.7, 1], [-0.7, 1]]) path.lineTo(x + dx * r, y + dy * r);
    path.closePath();
  },
  red: (path, x, y, r) => {
    for (const [dx, dy] of [[-0.36, -1.17], [0.97, -0.73], [0.36, 1.17], [-0.97, 0.73]]) {
      path.lineTo(x + dx * r, y + dy * r); // leans by 18 degrees
    }
    path.closePath();
  },
  diamond: polygon(4),
  pentagon: polygon(5),
  star: polygon(5, -Math.PI / 2, 0.45),
  wedge: polygon(3, Math.PI),
  cross: lines([-D, -D, D, D], [-D, D, D, -D]),
  plus: lines([-D, 0, D, 0], [0, -D, 0, D]),
  peak: lines([-1, 0.5, 0, -0.5], [0, -0.5, 1, 0.5]),
  trough: lines([-1, -0.5, 0, 0.5], [0, 0.5, 1, -0.5]),
  arrow_up: lines([0, 1.1, 0, -1.1], [-0.8, -0.2, 0, -1.1], [0, -1.1, 0.8, -0.2]),
  arrow_down: lines([0, -1.1, 0, 1.1], [-0.8, 0.2, 0, 1.1], [0, 1.1, 0.8, 0.2]),
  bar: lines([0, -1.4, 0, 1.4]),
};
const LINES = new Set(["cross", "plus", "bar", "peak", "trough", "arrow_up", "arrow_down"]);
/** Return whether a shape is drawn as lines: "open_square" is the outline of a square. @param {string} shape */
const isOpen = (shape) => LINES.has(shape) || shape.startsWith("open_");
const LARGE = new Set(["circle", "hexagon"]);

/**
 * Return the radius (px) of a shape; `size` is that of a common one.
 * @param {string} shape
 * @param {number} size
 */
export function sizeOf(shape, size) {
  if (LARGE.has(shape)) return 1.35 * size;
  return isOpen(shape) ? 0.8 * size : size;
}

/**
 * Draw a mark, filled with `colour` and outlined with `rim`.
 * @param {PathContext} path
 * @param {string} shape
 * @param {number} x
 * @param {number} y
 * @param {number} size
 * @param {string} colour
 * @param {string} rim
 */
export function drawMark(path, shape, x, y, size, colour, rim) {
  path.beginPath();
  (SHAPES[shape.replace("open_", "")] ?? SHAPES.circle)(path, x, y, sizeOf(shape, size));
  if (isOpen(shape)) {
    path.lineWidth = size / 3;
    path.strokeStyle = colour;
    path.stroke();
    return;
  }
  path.fillStyle = colour;
  path.fill();
  path.lineWidth = 1.25;
  path.strokeStyle = rim;
  path.stroke();
}

/** @type {Record<string, string>} */
const COLOURS = {
  yellow_card: "card", red_card: "red", highest: "one", lowest: "two", peak: "one", trough: "two",
  record_high: "one", record_low: "two", largest_rise: "one", largest_fall: "two", crossing_up: "one",
  crossing_down: "two",
};

const CARDS = new Set(["card", "red"]);

/**
 * Return the mark of an event kind; `side` is the team (1 or 2), if it is known.
 * @param {string} id
 * @param {Pick<Kind, "shape">} kind
 * @param {number} [side]
 * @returns {Mark}
 */
export function markOf(id, { shape }, side) {
  const own = COLOURS[id] ?? "ink";
  const team = side ? ["one", "two"][side - 1] : null;
  if (CARDS.has(own)) return { shape, colour: own, rim: team ?? "ink", isRing: false };
  return { shape, colour: team ?? own, isRing: side === 2 };
}

/**
 * Draw a mark with the colours of the page, within a rim of paper.
 * @param {PathContext} path
 * @param {Mark} mark
 * @param {number} x
 * @param {number} y
 * @param {number} size
 * @param {Record<string, string>} colours
 */
export function drawKind(path, { shape, colour, rim = "paper", isRing }, x, y, size, colours) {
  if (isOpen(shape)) drawMark(path, shape, x, y, size, colours[colour], colours.paper);
  else if (!isRing) drawMark(path, shape, x, y, size, colours[colour], colours[rim]);
  else {
    drawMark(path, shape, x, y, size, colours[colour], colours.paper);
    drawMark(path, shape, x, y, size * (shape === "circle" ? 0.6 : 0.45), colours.paper, colours.paper);
    if (shape === "circle") drawMark(path, shape, x, y, size * 0.3, colours[colour], colours[colour]);
  }
}
