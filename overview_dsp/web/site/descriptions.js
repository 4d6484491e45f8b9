// Texts for times, events and positions.

import { positionAt, secondsAt } from "./angle_map.js";
import { changeText, LOCALES, nearestPoint, numberText, rangeOf, valueText } from "./values.js";
import { begins, fromTo, NO_DATA, range } from "./words.js";

const TOLERANCE = 0.004; // distance (0 to 1) at which a position is at an event, without a picture
export const EXACT = 1e-9; // distance (0 to 1) that only rounding causes

/** @import { Info, TimelineEvent, View } from "../types" */

/** Return the distance (0 to 1) at which a position is at an event. @param {View} view */
export const toleranceOf = (view) => view.tolerance ?? TOLERANCE;

// created only once, because creating one takes longer than all else in a frame
/** @param {Intl.DateTimeFormatOptions} options */
export const dates = (options) => new Intl.DateTimeFormat(LOCALES, {
  timeZone: "UTC", calendar: "gregory", numberingSystem: "latn", ...options,
});
const DAYS = dates({ day: "numeric", month: "short", year: "numeric" });
const SPOKEN_DAYS = dates({ day: "numeric", month: "long", year: "numeric" });
export const HOURS = dates({ hour: "2-digit", minute: "2-digit" });
/** @type {Intl.DateTimeFormatOptions} */
const SECOND = { hour: "2-digit", minute: "2-digit", second: "2-digit" };
export const SECONDS = dates(SECOND);
const TIMES = dates({ weekday: "short", ...SECOND });

export const LONG_S = 3 * 86400; // from here on a date is more useful than a weekday

/**
 * Return the start of a timeline with a calendar in ms, in its own time zone; null without one.
 * @param {Pick<Info, "start">} info
 */
export function startOf({ start }) {
  return start === null ? null : Date.parse(`${start.replace(/(Z|[+-]\d\d:\d\d)$/, "")}Z`);
}

/**
 * Return minutes and seconds, or the date of a timeline with a calendar.
 * @param {number} seconds
 * @param {Info} info
 */
export function momentText(seconds, info, days = DAYS) {
  const start = startOf(info);
  if (start !== null) {
    const moment = new Date(start + 1e3 * seconds);
    if (info.duration_s <= LONG_S) return TIMES.format(moment);
    const day = days.format(moment);
    return info.series?.has_times ? `${day}, ${HOURS.format(moment)}` : day;
  }
  const short = info.duration_s < 120;
  const whole = short ? Math.floor(seconds) : Math.round(seconds);
  const minutes = Math.floor(whole / 60);
  const rest = String(whole % 60).padStart(2, "0");
  const hours = Math.floor(minutes / 60);
  const tenth = short ? `.${Math.floor((seconds - whole) * 10)}` : "";
  if (info.duration_s < 3 * 3600) return `${minutes}:${rest}${tenth}`;
  return `${hours}:${String(minutes % 60).padStart(2, "0")}:${rest}`;
}

/**
 * Return a time for speech, with the full name of the month.
 * @type {(seconds: number, info: Info) => string}
 */
export const spokenMoment = (seconds, info) => momentText(seconds, info, SPOKEN_DAYS);

const CROSSINGS = ["crossing_up", "crossing_down"];
const LABEL_ALONE = new Set(["period", ...CROSSINGS]);
const CALENDAR = new Set(["century", "decade", "year", "month", "week", "day"]);
// events that are found in a series: their labels repeat kind, value and date
const FOUND = new Set([
  "highest", "lowest", "record_high", "record_low", "largest_rise", "largest_fall", "peak", "trough",
]);

/**
 * Return kind and label of an event, without its date; kind and value if it is a point of the data.
 * @param {Pick<TimelineEvent, "kind" | "label" | "value" | "change">} event
 * @param {Info} info
 */
export function eventText(event, info) {
  const text = shortEvent(event, info);
  const isPoint = FOUND.has(event.kind) || CROSSINGS.includes(event.kind);
  return isPoint && event.value !== undefined ? `${text}, ${valueText(event.value, info)}` : text;
}

/**
 * Return kind and label of an event, without value and date; the kind is left out if the label
 * contains it.
 * @param {Pick<TimelineEvent, "kind" | "label" | "change">} event
 * @param {Info} info
 */
export function shortEvent({ kind, label, change }, info) {
  const words = info.kinds[kind]?.name ?? kind;
  if (info.start && CALENDAR.has(kind)) return begins(words);
  if (LABEL_ALONE.has(kind)) return label || words;
  if (FOUND.has(kind)) return change ? `${words}, ${changeText(change, info)}` : words;
  if (!label) return words;
  return label.toLowerCase().includes(words.toLowerCase()) ? label : `${words}, ${label}`;
}

/**
 * Return the event at a position of a window, or null. A position that is exactly that of a data
 * point, such as the highest, belongs to this point and not to an event beside it.
 * @param {View} view
 * @param {number} position
 * @returns {TimelineEvent | null}
 */
export function eventAt(view, position) {
  /** @type {TimelineEvent | null} */
  let nearest = null;
  for (const event of view.events) {
    const away = Math.abs(event.position - position);
    if (away <= toleranceOf(view) && (!nearest || away < Math.abs(nearest.position - position))) nearest = event;
  }
  if (nearest === null || Math.abs(nearest.position - position) < EXACT) return nearest;
  return isAtPoint(view, position) ? null : nearest;
}

/**
 * Return the last event between two positions of the disk, or null.
 * @param {View} view
 * @param {number} from
 * @param {number} to
 * @returns {TimelineEvent | null}
 */
export function eventPassed(view, from, to) {
  const [low, high] = from < to ? [from, to] : [to, from];
  const passed = view.events.filter(({ position }) => position > low && position <= high);
  return (from < to ? passed.at(-1) : passed[0]) ?? null;
}

/**
 * Return whether a position is exactly that of a data point.
 * @param {View} view
 * @param {number} position
 */
export function isAtPoint(view, position) {
  const point = nearestPoint(view, secondsAt(view, position));
  return point !== null && Math.abs(positionAt(view, point.time_s) - position) < EXACT;
}

/**
 * Return the ends of the gap around a position; undefined where there are data.
 * @param {View} view
 * @param {number} position
 */
const gapAt = (view, position) => view.gaps.find(([from, to]) => position > from && position < to);

/**
 * Return the moments between which there are no data, for the gap around a position; "" where there are data.
 * @param {View} view
 * @param {number} position
 * @param {Info} info
 */
export function gapText(view, position, info) {
  const [from, to] = (gapAt(view, position) ?? []).map((end) => momentText(secondsAt(view, end), info));
  return from ? fromTo(from, to) : "";
}

/**
 * Return the spoken text of a position: "702.10 dollars, 19 September 2012, peak". Events at one
 * position are all named. Without `withValue` an event that is not at a data point has no value.
 * @param {View} view
 * @param {number} position
 * @param {Info} info
 */
export function positionText(view, position, info, withValue = true) {
  const here = eventAt(view, position);
  const at = here?.position ?? position;
  const events = here ? view.events.filter((one) => Math.abs(one.position - at) < EXACT) : [];
  const texts = events.map((one) => shortEvent(one, info));
  const moment = here?.time_s ?? secondsAt(view, position);
  const isGap = gapAt(view, at) !== undefined;
  const point = isGap ? null : nearestPoint(view, moment);
  if (point && (withValue || isAtPoint(view, position))) {
    return [valueText(point.value, info), spokenMoment(point.time_s, info), ...texts].join(", ");
  }
  const state = isGap ? NO_DATA.toLowerCase() : texts.length === 0 && scoreAt(view, at);
  return [spokenMoment(moment, info), state, ...texts].filter(Boolean).join(", ");
}

/**
 * Return the number at a position as text, without its unit; "No data" in a gap of a series.
 * @param {View} view
 * @param {number} position
 * @param {Info} info
 */
export function numberAt(view, position, info) {
  if (gapAt(view, position)) return info.series ? NO_DATA : "";
  const here = eventAt(view, position);
  return numberText(nearestPoint(view, here?.time_s ?? secondsAt(view, position))?.value, info);
}

/**
 * Return the score at a position; "" before the first goal.
 * @param {View} view
 * @param {number} position
 */
export function scoreAt(view, position) {
  const goals = view.events.filter((one) => one.score && one.position <= position + toleranceOf(view));
  return goals.at(-1)?.score ?? view.score ?? "";
}

/**
 * Return a summary of a window: time range, value range and number of events.
 * @param {View} view
 * @param {Info} info
 */
export function summaryText(view, info) {
  const parts = [
    `${info.title}: ${fromTo(spokenMoment(view.start_s, info), spokenMoment(view.end_s, info))}`,
  ];
  if (view.points?.value.length) {
    const [lowest, highest] = rangeOf(view);
    parts.push(range(valueText(lowest, info), valueText(highest, info)));
  }
  const counts = new Map();
  for (const { kind } of view.events) {
    if (info.kinds[kind].shape !== "bar") counts.set(kind, (counts.get(kind) ?? 0) + 1);
  }
  const kinds = [...counts].map(([kind, count]) => `${info.kinds[kind].name}: ${count}`);
  return [...parts, ...kinds].join("; ");
}
