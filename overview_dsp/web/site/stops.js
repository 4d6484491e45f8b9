// Positions of a window at which keys and buttons stop: each value and each event exactly once.

import { positionAt } from "./angle_map.js";
import { EXACT, toleranceOf } from "./descriptions.js";

/** @import { View } from "../types" */

const GRID = 100; // steps of a window without values

/**
 * Return the positions of the window's values; [] for data without values.
 * @param {View} view
 */
export function valueStops(view) {
  const times = (view.points?.time_s ?? []).filter((one) => one >= view.start_s && one <= view.end_s);
  return times.map((one) => positionAt(view, one));
}

/**
 * Return the positions of the window's events.
 * @param {View} view
 */
export const eventStops = ({ events }) => distinct(events.map(({ position }) => position));

/**
 * Return the stops of arrow keys: values and events; without values events, and steps between them.
 * @param {View} view
 */
export function allStops(view) {
  const values = valueStops(view);
  const events = eventStops(view);
  if (values.length > 0) return distinct([...values, ...events]);
  const steps = Array.from({ length: GRID + 1 }, (_, i) => i / GRID)
    .filter((step) => events.every((position) => Math.abs(position - step) > toleranceOf(view)));
  return distinct([...events, ...steps]);
}

/** @param {number[]} positions */
function distinct(positions) {
  const sorted = positions.toSorted((a, b) => a - b);
  return sorted.filter((position, i) => i === 0 || position - sorted[i - 1] > EXACT);
}

/**
 * Return the next stop after (1) or before (-1) a position; undefined without one.
 * @param {number[]} stops ascending
 * @param {number} position
 * @param {number} direction
 */
export function nextStop(stops, position, direction) {
  return direction > 0
    ? stops.find((stop) => stop > position + EXACT)
    : stops.findLast((stop) => stop < position - EXACT);
}
