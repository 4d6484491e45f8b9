// Map between time and position of a window, with the same points as in Python.

/** @import { AngleMap, TimeRange, View } from "../types" */

/** @typedef {TimeRange & { angle_map?: AngleMap | null }} Mapped */

/**
 * Return the time (s) at a position of a window.
 * @param {Mapped} view
 * @param {number} position
 */
export function secondsAt({ angle_map: map, start_s, end_s }, position) {
  if (!map) return start_s + (end_s - start_s) * position;
  return between(map.position, map.time_s, position);
}

/**
 * Return the position (0 to 1) of a time (s), clamped to the window.
 * @param {Mapped} view
 * @param {number} moment
 */
export function positionAt({ angle_map: map, start_s, end_s }, moment) {
  if (map) return between(map.time_s, map.position, moment);
  return Math.min(Math.max((moment - start_s) / (end_s - start_s), 0), 1);
}

/**
 * Return the map between two positions of a window; null if it is linear.
 * @param {View} view
 * @param {number} from
 * @param {number} to
 * @returns {AngleMap | null}
 */
export function croppedMap(view, from, to) {
  if (!view.angle_map) return null;
  const { time_s, position } = view.angle_map;
  const inside = position.map((_, i) => i).filter((i) => position[i] > from && position[i] < to);
  return {
    time_s: [secondsAt(view, from), ...inside.map((i) => time_s[i]), secondsAt(view, to)],
    position: [0, ...inside.map((i) => (position[i] - from) / (to - from)), 1],
  };
}

/**
 * @param {number[]} x ascending; of equal ones the last counts
 * @param {number[]} y
 * @param {number} at
 */
function between(x, y, at) {
  const last = x.length - 1;
  if (at <= x[0]) return y[0];
  if (at >= x[last]) return y[last];
  let low = 0;
  let high = last;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (x[middle] <= at) low = middle;
    else high = middle;
  }
  return y[low] + ((at - x[low]) / (x[high] - x[low])) * (y[high] - y[low]);
}
