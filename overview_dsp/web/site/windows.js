// Which part comes next: the nearest of another level about a moment, or the one beside. A part is
// a window of the list by its number, or any other (number -1) that a host shows.

import { croppedMap, placeAt } from "./angle_map.js";

const SAME_S = 1e-6;

/** @import { Info, Part, View, Window } from "../types" */

/**
 * Window `i` as a part.
 * @param {Window[]} windows
 * @param {number} i
 * @returns {Part}
 */
export function partOf(windows, i) {
  const { level, start_s, end_s } = windows[i];
  return { number: i, zoom: level, start_s, end_s };
}

/**
 * The part from `start` to `end` (s): one of the windows, or one of its own.
 * @param {Window[]} windows
 * @param {[number, number]} ends
 * @returns {Part}
 */
export function partBetween(windows, [start, end]) {
  /** @param {Window} window */
  const same = ({ start_s, end_s }) =>
    Math.abs(start_s - start) < SAME_S && Math.abs(end_s - end) < SAME_S;
  const number = windows.findIndex(same);
  if (number >= 0) return partOf(windows, number);
  // of those as long or longer, the narrowest
  const wider = windows.filter((one) => one.end_s - one.start_s >= end - start - SAME_S);
  const zoom = Math.max(...wider.map(({ level }) => level));
  return { number, zoom, start_s: start, end_s: end };
}

/** @type {(window: Window) => boolean} */
const anyWindow = () => true;

/**
 * The part of `level` whose middle is nearest to a moment (s), of those that will do, or null.
 * @param {Window[]} windows
 * @param {number} level
 * @param {number} moment
 */
export function partAbout(windows, level, moment, willDo = anyWindow) {
  let best = -1;
  let least = Infinity;
  windows.forEach((window, i) => {
    const away = Math.abs((window.start_s + window.end_s) / 2 - moment);
    if (window.level === level && away < least && willDo(window)) [best, least] = [i, away];
  });
  return best < 0 ? null : partOf(windows, best);
}

/**
 * The part of a window (s) among `windows`, as long and as near as any is.
 * @param {Window[]} windows
 * @param {[number, number]} ends
 */
export function partNearest(windows, [start, end]) {
  /** @param {Window} window */
  const away = ({ start_s, end_s }) => Math.abs(Math.log((end_s - start_s) / (end - start)));
  const { level } = windows.reduce((a, b) => (away(b) < away(a) ? b : a));
  return partAbout(windows, level, (start + end) / 2);
}

/**
 * What a view shows of a window (s) of it, as a view.
 * @param {View} view
 * @param {[number, number]} ends
 * @returns {View}
 */
export function croppedTo(view, [start_s, end_s]) {
  const { level, resistance } = view;
  const from = placeAt(view, start_s);
  const part = placeAt(view, end_s) - from;
  const last = level.length - 1;
  const columns = level.map((_, i) => Math.round((from + (part * i) / last) * last));
  const placed = (/** @type {number} */ place) => (place - from) / part;
  const inside = (/** @type {number} */ place) => Math.min(Math.max(placed(place), 0), 1);
  /** @type {(a: number, b: number) => [number, number]} */
  const both = (a, b) => [a, b];
  return {
    ...view, start_s, end_s,
    map: croppedMap(view, from, from + part),
    level: columns.map((i) => level[i]),
    resistance: columns.map((i) => resistance[i]),
    gaps: view.gaps.map(([a, b]) => both(inside(a), inside(b))).filter(([a, b]) => b > a),
    events: view.events
      .map((event) => ({ ...event, place: placed(event.place) }))
      .filter(({ place }) => place >= 0 && place <= 1),
  };
}

/**
 * The part beside another, earlier (-1) or later (1), half of it new; null at the ends.
 * @param {Window[]} windows
 * @param {Part} part
 * @param {number} direction
 * @returns {Part | null}
 */
export function partBeside(windows, part, direction) {
  if (part.number < 0) {
    const middle = (part.start_s + part.end_s) / 2;
    const wanted = middle + (direction * (part.end_s - part.start_s)) / 2;
    return partAbout(windows, part.zoom, wanted, ({ start_s, end_s }) =>
      direction > 0 ? end_s > part.end_s : start_s < part.start_s,
    );
  }
  const beside = part.number + direction;
  return windows[beside]?.level === part.zoom ? partOf(windows, beside) : null;
}

/** @param {Window[]} windows */
export function levels(windows) {
  return windows.at(-1).level;
}

/**
 * The part that is shown first: a server's, or the whole.
 * @param {Info} info
 */
export function firstPart({ windows, duration_s, server }) {
  return partBetween(windows, server?.window ?? [0, duration_s]);
}
