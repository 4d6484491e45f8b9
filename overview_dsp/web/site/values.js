// The data's own values at the points nearest to a position; values are never interpolated.

import { positionAt } from "./angle_map.js";

/** @import { Info, Points, View } from "../types" */

/** Languages of the reader, for dates and numbers; without a window those of the tests. */
export const LOCALES = /** @type {string[]} */ (globalThis.window ? navigator.languages : ["en-GB"]);

/** @type {Map<number, Intl.NumberFormat>} */
const formats = new Map(); // by their decimals

/**
 * Return a number as the reader writes it.
 * @param {number} value
 * @param {number} decimals
 */
function localNumber(value, decimals, sign = "") {
  let format = formats.get(decimals);
  if (!format) {
    format = new Intl.NumberFormat(LOCALES, {
      minimumFractionDigits: decimals, maximumFractionDigits: decimals, useGrouping: "min2", numberingSystem: "latn",
    });
    formats.set(decimals, format);
  }
  return (value > 0 ? sign : "") + format.format(value + 0).replace("-", "\u2212"); // no sign of zero
}

/**
 * Return the index of the point nearest to a time (s); -1 without points.
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
 * Return time (s) and value of the point nearest to a time; null without points.
 * @param {{ points: Points | null }} view
 * @param {number} moment
 */
export function nearestPoint({ points }, moment) {
  const i = pointAt({ points }, moment);
  return points === null || i < 0 ? null : { time_s: points.time_s[i], value: points.value[i] };
}

/**
 * Return a value with its unit and the data's decimals; "" without a value.
 * @param {number | undefined} value
 * @param {Pick<Info, "series">} info
 */
export function valueText(value, { series }) {
  const text = numberText(value, { series });
  return text && series?.unit ? `${text} ${series.unit}` : text;
}

/**
 * Return a value with the data's decimals, without its unit; "" without a value.
 * @param {number | undefined} value
 * @param {Pick<Info, "series">} info
 */
export function numberText(value, { series }) {
  return value === undefined || !series ? "" : localNumber(value, series.decimals);
}

/**
 * Return a change with its sign and unit; a unit that is not the values' is per cent.
 * @param {[number, string]} change
 * @param {Pick<Info, "series">} info
 */
export function changeText([change, unit], { series }) {
  const decimals = unit === series?.unit ? series.decimals : 2;
  return `${localNumber(change, decimals, "+")} ${unit}`.trim();
}

/**
 * Return the position (0 to 1) of the highest (1) or lowest (-1) point of a window or its curve.
 * @param {View} view
 * @param {number} direction
 */
export function extremeOf(view, direction) {
  const [values, first, last, positionOf] = within(view);
  let best = first;
  let most = values[first];
  for (let i = first; i <= last; i += 1) {
    const value = values[i];
    if (most === null || (value !== null && (value - most) * direction > 0)) [best, most] = [i, value];
  }
  return Math.min(Math.max(positionOf(best), 0), 1);
}

/**
 * Return the lowest and the highest value of a window.
 * @param {View} view
 */
export function rangeOf(view) {
  const [values, first, last] = within(view);
  const some = values.slice(first, last + 1).filter((one) => one !== null);
  return [some.reduce((a, b) => Math.min(a, b)), some.reduce((a, b) => Math.max(a, b))];
}

/**
 * Return a window's values, the first and last index within it, and a function for their positions.
 * @param {View} view
 * @returns {[(number | null)[], number, number, (i: number) => number]}
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
    (i) => positionAt(view, points.time_s[i]),
  ];
}

/**
 * Return a few round values for grid lines, each as text and level (0 to 1).
 * @param {[number, number]} scale
 * @param {number} maxLines
 */
export function linesOf([low, span], maxLines) {
  if (!(span > 0)) return [];
  const least = span / maxLines;
  const power = 10 ** Math.floor(Math.log10(least));
  const step = power * ([1, 2, 5].find((one) => one * power >= least) ?? 10);
  const lines = [];
  for (let i = Math.ceil(low / step); i * step <= low + span * 1.0001; i += 1) {
    lines.push({ value: i * step, level: (i * step - low) / span });
  }
  const decimals = Math.max(0, -Math.floor(Math.log10(step)));
  return lines.map(({ value, level }) => ({
    text: localNumber(value, decimals), level,
  }));
}
