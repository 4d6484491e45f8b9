// A window's map between moments and places: the same points and the same lines as in Python.

/** @import { AngleMap, Ends, View } from "../types" */

/** @typedef {Ends & { map?: AngleMap | null }} Mapped */

/**
 * The moment (s) at a place of a window.
 * @param {Mapped} view
 * @param {number} place
 */
export function secondsAt({ map, start_s, end_s }, place) {
  if (!map) return start_s + (end_s - start_s) * place;
  return between(map.place, map.time_s, place);
}

/**
 * The place (0 to 1) of a moment (s) of a window; beyond an end the end's.
 * @param {Mapped} view
 * @param {number} moment
 */
export function placeAt({ map, start_s, end_s }, moment) {
  if (map) return between(map.time_s, map.place, moment);
  return Math.min(Math.max((moment - start_s) / (end_s - start_s), 0), 1);
}

/**
 * The map of what lies between two places of a window, or null where it is linear.
 * @param {View} view
 * @param {number} from
 * @param {number} to
 * @returns {AngleMap | null}
 */
export function croppedMap(view, from, to) {
  if (!view.map) return null;
  const { time_s, place } = view.map;
  const inside = place.map((_, i) => i).filter((i) => place[i] > from && place[i] < to);
  return {
    time_s: [secondsAt(view, from), ...inside.map((i) => time_s[i]), secondsAt(view, to)],
    place: [0, ...inside.map((i) => (place[i] - from) / (to - from)), 1],
  };
}

/**
 * The parts of a window that the map makes at least half as wide again as time is.
 * @param {View} view
 * @returns {[number, number][]}
 */
export function stretched({ map, start_s, end_s }) {
  if (!map) return [];
  const { time_s, place } = map;
  /** @type {[number, number][]} */
  const parts = [];
  for (let i = 1; i < place.length; i += 1) {
    const even = (time_s[i] - time_s[i - 1]) / (end_s - start_s);
    if (place[i] - place[i - 1] >= 1.5 * even) parts.push([place[i - 1], place[i]]);
  }
  return parts;
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
