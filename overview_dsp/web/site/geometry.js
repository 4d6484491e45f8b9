// Where everything lies in the picture, in CSS pixels.

const LEAST_DISK = 0.4; // of the screen's shorter side
const MOST_DISK = 0.3; // of a wide picture's width
const LEAST_PLOT = 48;
const RIM = 16; // about the disk: the events on it
const TRACE = 84; // a trace with its label

/** @import { Disk, Geometry } from "../types" */

/**
 * Boxes of the curve, the disk and the trace in a picture of `width` by `height`: the disk below
 * the curve, or beside it where the picture is wide. `short`: the screen's shorter side; `em`: how much
 * larger than usual text is; `still`: without what moves.
 * @param {{ width: number, height: number, short: number, em: number, still: boolean }} picture
 * @returns {Geometry}
 */
export function geometryOf({ width, height, short, em, still }) {
  const side = width >= 760 ? 26 : 18;
  const axis = Math.round(26 * em);
  /** @type {Geometry} */
  const made = {
    width, height, em, left: side, right: width - side, top: 26, bottom: height - axis - 6,
    axis, disk: null, trace: null,
    x: (place) => made.left + (made.right - made.left) * place,
    y: (level) => made.bottom - (made.bottom - made.top) * level * 0.92,
    place: (x) => Math.min(Math.max((x - made.left) / (made.right - made.left), 0), 1),
  };
  if (still) return made;
  const least = LEAST_DISK * short;
  const below = height - made.top - LEAST_PLOT - axis - least - 2 * RIM;
  if (width > 1.2 * height || below < 0) beside(made, least, side);
  else under(made, least);
  return made;
}

/**
 * @param {Geometry} g
 * @param {number} least
 * @param {number} side
 */
function beside(g, least, side) {
  const { width, height } = g;
  const most = height - 2 * RIM - 8;
  const radius = Math.min(Math.max(least, Math.min(most, MOST_DISK * width)), most) / 2;
  g.disk = { x: width - side - RIM - radius, y: height / 2, radius };
  g.right = g.disk.x - radius - 2 * RIM - 6;
  if (height < 230) return;
  const room = Math.max(TRACE, height * 0.2);
  g.bottom = height - room - g.axis - 6;
  g.trace = { left: g.left, right: g.right, y: height - room / 2 + 6, half: room / 2 - 18 };
}

/**
 * @param {Geometry} g
 * @param {number} least
 */
function under(g, least) {
  const { width, height, axis } = g;
  // half for the curve, as far as the disk leaves it
  const free = height - g.top - axis - least - 2 * RIM;
  const traced = free > LEAST_PLOT + TRACE + 10 ? TRACE : 0;
  const plot = Math.max(LEAST_PLOT, Math.min(free - traced, height * 0.36));
  g.bottom = g.top + plot;
  const from = g.bottom + axis + RIM;
  const room = height - from - RIM - traced;
  const radius = Math.max(least / 2, Math.min(room / 2, width * 0.34));
  g.disk = { x: width / 2, y: from + Math.max(room / 2, radius), radius };
  if (traced) g.trace = { left: g.left, right: g.right, y: height - TRACE / 2 + 8, half: 26 };
}

/**
 * The angle on the disk of a place: the start at nine o'clock, over the top, the end at three.
 * @param {number} place
 */
export function angleOf(place) {
  return Math.PI * (1 + place);
}

/**
 * The place at which the disk is turned by a finger there; below it, the end it was nearer to.
 * @param {Disk} disk
 * @param {number} x
 * @param {number} y
 * @param {number} last
 */
export function placeTurned(disk, x, y, last) {
  const dx = x - disk.x;
  const dy = y - disk.y;
  if (dy >= 0) return last < 0.5 ? 0 : 1;
  return Math.min(Math.max(1 + Math.atan2(dy, dx) / Math.PI, 0), 1);
}

/**
 * Whether the drawn disk is there.
 * @param {Geometry} geometry
 * @param {number} x
 * @param {number} y
 */
export function isOnDisk({ disk }, x, y) {
  return disk !== null && Math.hypot(x - disk.x, y - disk.y) < disk.radius + RIM;
}
