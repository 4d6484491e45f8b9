// Marks of the event kinds, which differ in shape as well as colour.

/** @import { PathContext } from "../types" */
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
  square: polygon(4, Math.PI / 4),
  diamond: polygon(4),
  pentagon: polygon(5),
  star: polygon(5, -Math.PI / 2, 0.45),
  wedge: polygon(3, Math.PI),
  cross: lines([-D, -D, D, D], [-D, D, D, -D]),
  plus: lines([-D, 0, D, 0], [0, -D, 0, D]),
  bar: lines([0, -1.4, 0, 1.4]),
};
const OPEN = new Set(["cross", "plus", "bar"]);
const LARGE = new Set(["circle", "hexagon"]);

/**
 * Return the radius (px) of a shape; `size` is that of a common one.
 * @param {string} shape
 * @param {number} size
 */
export function sizeOf(shape, size) {
  if (LARGE.has(shape)) return 1.35 * size;
  return OPEN.has(shape) ? 0.8 * size : size;
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
  (SHAPES[shape] ?? SHAPES.circle)(path, x, y, sizeOf(shape, size));
  if (OPEN.has(shape)) {
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
