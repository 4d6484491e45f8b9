// Choice of windows: by zoom level, by time, or adjacent. A part is a listed window by its number, or any
// other window (number -1) that a host shows.

import { croppedMap, positionAt } from "./angle_map.js";

const SAME_S = 1e-6;

/** @import { Info, Part, View, Window } from "../types" */

/**
 * Return window `i` as a part.
 * @param {Window[]} windows
 * @param {number} i
 * @returns {Part}
 */
export function partOf(windows, i) {
  const { level, start_s, end_s } = windows[i];
  return { number: i, zoom: level, start_s, end_s };
}

/**
 * Return the part from `start` to `end` (s).
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
  // the narrowest window that is at least as long
  const wider = windows.filter((one) => one.end_s - one.start_s >= end - start - SAME_S);
  const zoom = Math.max(...wider.map(({ level }) => level));
  return { number, zoom, start_s: start, end_s: end };
}

/**
 * Return the shortest listed part that contains a window (s).
 * @param {Window[]} windows
 * @param {[number, number]} ends
 */
export function partContaining(windows, [start, end]) {
  /** @param {number} i */
  const length = (i) => windows[i].end_s - windows[i].start_s;
  const holding = [...windows.keys()].filter((i) => windows[i].start_s <= start && windows[i].end_s >= end);
  return partOf(windows, holding.reduce((a, b) => (length(b) < length(a) ? b : a), 0));
}

/** @type {(window: Window) => boolean} */
const anyWindow = () => true;

/**
 * Return the allowed part of `level` whose middle is nearest to a time (s), or null.
 * @param {Window[]} windows
 * @param {number} level
 * @param {number} moment
 */
export function partAround(windows, level, moment, isAllowed = anyWindow) {
  let best = -1;
  let least = Infinity;
  windows.forEach((window, i) => {
    const away = Math.abs((window.start_s + window.end_s) / 2 - moment);
    if (window.level === level && away < least && isAllowed(window)) [best, least] = [i, away];
  });
  return best < 0 ? null : partOf(windows, best);
}

/**
 * Return the listed part nearest to a window (s) in length and time.
 * @param {Window[]} windows
 * @param {[number, number]} ends
 */
export function partNearest(windows, [start, end]) {
  /** @param {Window} window */
  const away = ({ start_s, end_s }) => Math.abs(Math.log((end_s - start_s) / (end - start)));
  const { level } = windows.reduce((a, b) => (away(b) < away(a) ? b : a));
  return partAround(windows, level, (start + end) / 2);
}

/**
 * Return a view of a window (s) within another view.
 * @param {View} view
 * @param {[number, number]} ends
 * @returns {View}
 */
export function croppedTo(view, [start_s, end_s]) {
  const { level } = view;
  const from = positionAt(view, start_s);
  const part = positionAt(view, end_s) - from;
  const last = level.length - 1;
  const columns = level.map((_, i) => Math.round((from + (part * i) / last) * last));
  const placed = (/** @type {number} */ position) => (position - from) / part;
  const inside = (/** @type {number} */ position) => Math.min(Math.max(placed(position), 0), 1);
  /** @type {(a: number, b: number) => [number, number]} */
  const both = (a, b) => [a, b];
  return {
    ...view, start_s, end_s,
    angle_map: croppedMap(view, from, from + part),
    level: columns.map((i) => level[i]),
    gaps: view.gaps.map(([a, b]) => both(inside(a), inside(b))).filter(([a, b]) => b > a),
    events: view.events
      .map((event) => ({ ...event, position: placed(event.position) }))
      .filter(({ position }) => position >= 0 && position <= 1),
  };
}

/**
 * Return the adjacent part, earlier (-1) or later (1), which overlaps by half; null at the ends.
 * @param {Window[]} windows
 * @param {Part} part
 * @param {number} direction
 * @returns {Part | null}
 */
export function neighbourPart(windows, part, direction) {
  if (part.number < 0) {
    const middle = (part.start_s + part.end_s) / 2;
    const target = middle + (direction * (part.end_s - part.start_s)) / 2;
    return partAround(windows, part.zoom, target, ({ start_s, end_s }) =>
      direction > 0 ? end_s > part.end_s : start_s < part.start_s,
    );
  }
  const beside = part.number + direction;
  return windows[beside]?.level === part.zoom ? partOf(windows, beside) : null;
}

/** @param {Window[]} windows */
export function lastLevel(windows) {
  return windows[windows.length - 1].level;
}

/**
 * Return the first part to show: that of the server, or the whole timeline.
 * @param {Info} info
 */
export function firstPart({ windows, duration_s, server }) {
  return partBetween(windows, server?.window ?? [0, duration_s]);
}
