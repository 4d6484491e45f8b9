// The data's own values: the point nearest to a place of a window, never one made up between two.

import { placeAt } from "./angle_map.js";

/** @import { Info, Points, View } from "../types" */

/**
 * Index of the point of a window nearest to a moment (s), -1 where there is none.
 * @param {{ points: Points | null }} view
 * @param {number} moment
 */
export function pointAt(view, moment) {
  const times = view.points?.time_s ?? [];
  if (times.length === 0) return -1;
  let low = 0;
  let high = times.length - 1;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] < moment) low = middle + 1;
    else high = middle;
  }
  return low > 0 && moment - times[low - 1] <= times[low] - moment ? low - 1 : low;
}

/**
 * A value with its unit, as many decimals as the data have; "" without a value.
 * @param {number | undefined} value
 * @param {Pick<Info, "series">} info
 */
export function valueText(value, { series }) {
  if (value === undefined || !series) return "";
  const text = value.toFixed(series.decimals).replace("-", "\u2212");
  return series.unit ? `${text} ${series.unit}` : text;
}

/**
 * Where the highest (1) or lowest (-1) of a window is, 0 to 1: of its points, or of its curve.
 * @param {View} view
 * @param {number} direction
 */
export function extremeOf(view, direction) {
  const [values, first, last, placeOf] = within(view);
  let best = first;
  for (let i = first; i <= last; i += 1) {
    if ((values[i] - values[best]) * direction > 0) best = i;
  }
  return Math.min(Math.max(placeOf(best), 0), 1);
}

/**
 * The lowest and the highest value of a window.
 * @param {View} view
 */
export function rangeOf(view) {
  const [values, first, last] = within(view);
  const some = values.slice(first, last + 1);
  return [some.reduce((a, b) => Math.min(a, b)), some.reduce((a, b) => Math.max(a, b))];
}

/**
 * Values of a window, the first and the last that lie in it, and the place of each.
 * @param {View} view
 * @returns {[number[], number, number, (i: number) => number]}
 */
function within(view) {
  const { points, level, start_s, end_s } = view;
  if (!points || points.value.length === 0) {
    return [level, 0, level.length - 1, (i) => i / (level.length - 1)];
  }
  const first = pointAt(view, start_s);
  const last = pointAt(view, end_s);
  const inside = first + (points.time_s[first] < start_s && first < last ? 1 : 0);
  return [
    points.value, inside, last - (points.time_s[last] > end_s && last > inside ? 1 : 0),
    (i) => placeAt(view, points.time_s[i]),
  ];
}

/**
 * Values at which a line is drawn, few and round, and where they are (level 0 to 1).
 * @param {[number, number]} scale
 * @param {number} most
 */
export function linesOf([low, span], most) {
  if (!(span > 0)) return [];
  const least = span / most;
  const power = 10 ** Math.floor(Math.log10(least));
  const step = power * [1, 2, 5, 10].find((one) => one * power >= least);
  const lines = [];
  for (let i = Math.ceil(low / step); i * step <= low + span * 1.0001; i += 1) {
    lines.push({ value: i * step, level: (i * step - low) / span });
  }
  const decimals = Math.max(0, -Math.floor(Math.log10(step)));
  return lines.map(({ value, level }) => ({
    text: value.toFixed(decimals).replace("-", "\u2212"), level,
  }));
}
