// Layout of the picture, in CSS pixels: the curve, and below it the groove with the disk.

const LEAST_PLOT = 30;
const RIM = 16; // space around the dial in which a touch turns it
const LOW = 250; // height of a picture with a smaller disk
const LANE = [16, 24]; // distance (px) of two lanes in a low and in another picture
const BELOW = 24;
const DIAL = 0.34; // radius of the dial, as a share of the plot

/** @import { Disk, Geometry } from "../types" */

/**
 * Return the boxes of curve, groove, disk and dial in a picture of `width` by `height`. `em` scales the
 * text, `figures` is the width of the axis figures at the right, `lanes` the number of lanes
 * of marks above the curve. `circular` adds a dial, `still` leaves out the disk.
 * @param {{ width: number, height: number, em: number, still: boolean, circular?: boolean, figures?: number, lanes?: number }} picture
 * @returns {Geometry}
 */
export function geometryOf({ width, height, em, still, circular = false, figures = 0, lanes = 0 }) {
  const isLow = height < LOW * Math.max(em, 1);
  const radius = isLow ? 18 : 26;
  const between = isLow ? 4 : 10; // of axis and disk
  const side = radius + 8;
  const axis = Math.round(18 * em);
  const text = Math.round(15 * em);
  const apart = LANE[isLow ? 0 : 1];
  const end = height - axis - 2 * radius - 2 * between;
  // in a low picture both teams have one lane
  const isOne = lanes > 1 && end - 2 * text - apart - 26 < 2 * LEAST_PLOT;
  const ys = Array.from({ length: isOne ? 1 : lanes }, (_, i) => text + 12 + i * apart);
  // below the second lane there are texts, too
  const last = ys.at(-1) ?? 0;
  const under = ys.length > 1 ? text + between : 14;
  const top = lanes ? last + under : Math.round(14 * em) + (isLow ? 8 : 18);
  const bottom = Math.max(end, top + LEAST_PLOT);
  const below = lanes ? 0 : Math.min(BELOW, (bottom - top) / 5); // for marks below the curve
  const right = Math.max(width - side - figures, side + 1);
  /** @type {Geometry} */
  const geometry = {
    width, height, em, left: side, right, top, bottom, radius,
    lanes: ys, groove: bottom + between + radius, dial: null, still,
    x: (position) => side + (right - side) * position,
    y: (level) => bottom - below - (bottom - below - top) * level * 0.94,
    position: (x) => Math.min(Math.max((x - side) / (right - side), 0), 1),
  };
  if (circular && !still) {
    const size = DIAL * Math.min(right - side, (bottom - top) * 1.3);
    geometry.dial = { x: (side + right) / 2, y: (top + bottom) / 2, radius: Math.min(size, (bottom - top) / 2) };
  }
  return geometry;
}

/**
 * Return the disk's angle for a position: start at nine o'clock, end at three, clockwise.
 * @param {number} position
 */
export function angleOf(position) {
  return Math.PI * (1 + position);
}

/**
 * Return the position for a pointer on the dial; below the centre, the end nearer to `last`.
 * @param {Disk} dial
 * @param {number} x
 * @param {number} y
 * @param {number} last
 */
export function positionTurned(dial, x, y, last) {
  const dx = x - dial.x;
  const dy = y - dial.y;
  if (dy >= 0) return last < 0.5 ? 0 : 1;
  return Math.min(Math.max(1 + Math.atan2(dy, dx) / Math.PI, 0), 1);
}

/**
 * Return whether a point lies on the dial.
 * @param {Pick<Geometry, "dial">} geometry
 * @param {number} x
 * @param {number} y
 */
export function isOnDial({ dial }, x, y) {
  return dial !== null && Math.hypot(x - dial.x, y - dial.y) < dial.radius + RIM;
}
