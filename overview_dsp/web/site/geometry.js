// Layout of the picture, in CSS pixels.

const LEAST_DISK = 0.4; // of the screen's shorter side
const MOST_DISK = 0.3; // of a wide picture's width
const LEAST_PLOT = 48;
const RIM = 16; // space around the disk for its event marks
const TRACE = 84; // height of the trace with its label

/** @import { Disk, Geometry } from "../types" */

/**
 * Return the boxes of curve, disk and trace in a picture of `width` by `height`. The disk is below the
 * curve, or beside it in a wide picture. `short` is the screen's shorter side; `em` scales the text;
 * `still` leaves out disk and trace.
 * @param {{ width: number, height: number, short: number, em: number, still: boolean }} picture
 * @returns {Geometry}
 */
export function geometryOf({ width, height, short, em, still }) {
  const side = width >= 760 ? 26 : 18;
  const axis = Math.round(26 * em);
  /** @type {Geometry} */
  const geometry = {
    width, height, em, left: side, right: width - side, top: 26, bottom: height - axis - 6,
    axis, disk: null, trace: null,
    x: (position) => geometry.left + (geometry.right - geometry.left) * position,
    y: (level) => geometry.bottom - (geometry.bottom - geometry.top) * level * 0.92,
    position: (x) => Math.min(Math.max((x - geometry.left) / (geometry.right - geometry.left), 0), 1),
  };
  if (still) return geometry;
  const least = LEAST_DISK * short;
  const below = height - geometry.top - LEAST_PLOT - axis - least - 2 * RIM;
  if (width > 1.2 * height || below < 0) placeDiskBeside(geometry, least, side);
  else placeDiskBelow(geometry, least);
  return geometry;
}

/**
 * @param {Geometry} g
 * @param {number} least
 * @param {number} side
 */
function placeDiskBeside(g, least, side) {
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
function placeDiskBelow(g, least) {
  const { width, height, axis } = g;
  // half of the height for the curve, if the disk leaves enough space
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
 * Return the disk's angle for a position: start at nine o'clock, end at three, clockwise.
 * @param {number} position
 */
export function angleOf(position) {
  return Math.PI * (1 + position);
}

/**
 * Return the position for a pointer on the disk; below the centre, the end nearer to `last`.
 * @param {Disk} disk
 * @param {number} x
 * @param {number} y
 * @param {number} last
 */
export function positionTurned(disk, x, y, last) {
  const dx = x - disk.x;
  const dy = y - disk.y;
  if (dy >= 0) return last < 0.5 ? 0 : 1;
  return Math.min(Math.max(1 + Math.atan2(dy, dx) / Math.PI, 0), 1);
}

/**
 * Return whether a point lies on the disk.
 * @param {Geometry} geometry
 * @param {number} x
 * @param {number} y
 */
export function isOnDisk({ disk }, x, y) {
  return disk !== null && Math.hypot(x - disk.x, y - disk.y) < disk.radius + RIM;
}
