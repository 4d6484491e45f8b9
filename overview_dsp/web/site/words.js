// A place of a window in words: when it is, and what happened there.

import { secondsAt } from "./angle_map.js";
import { pointAt, rangeOf, valueText } from "./values.js";

const AT = 0.004; // of the surface: as near is at the event

/** @import { Info, TimelineEvent, View } from "../types" */

// made once: one takes longer than all else a frame does
const DAYS = new Intl.DateTimeFormat("en-GB", {
  timeZone: "UTC", day: "numeric", month: "short", year: "numeric",
});
const TIMES = new Intl.DateTimeFormat("en-GB", {
  timeZone: "UTC", weekday: "short", hour: "2-digit", minute: "2-digit", second: "2-digit",
});

const SPOKEN_DAYS = new Intl.DateTimeFormat("en-GB", {
  timeZone: "UTC", day: "numeric", month: "long", year: "numeric",
});

const HOURS = new Intl.DateTimeFormat("en-GB", {
  timeZone: "UTC", hour: "2-digit", minute: "2-digit",
});

const DAY_S = 86400;
const LONG_S = 3 * DAY_S; // a date says more than a weekday

/**
 * Minutes and seconds of a timeline, or its date where it has a calendar.
 * @param {number} seconds
 * @param {Info} info
 */
export function momentText(seconds, info, days = DAYS) {
  if (info.start) {
    const zone = info.start.match(/(Z|[+-]\d\d:\d\d)$/)?.[0] ?? "";
    const local = info.start.slice(0, info.start.length - zone.length);
    const moment = new Date(Date.parse(`${local}Z`) + 1e3 * seconds);
    if (info.duration_s <= LONG_S) return TIMES.format(moment);
    const day = days.format(moment);
    return info.series?.hours ? `${day}, ${HOURS.format(moment)}` : day;
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
 * A moment on an axis with a label every `step` s.
 * @param {number} seconds
 * @param {Info} info
 * @param {number} step
 */
export function tickText(seconds, info, step) {
  const days = info.start && info.duration_s > LONG_S && step >= DAY_S;
  return momentText(seconds, days ? { ...info, series: null } : info);
}

/**
 * A moment as it is said aloud: months in full.
 * @type {(seconds: number, info: Info) => string}
 */
export const spokenMoment = (seconds, info) => momentText(seconds, info, SPOKEN_DAYS);

const SAYS_ITSELF = new Set(["period", "crossing_up", "crossing_down"]);

/**
 * Kind and label of an event, without saying the kind twice.
 * @param {Pick<TimelineEvent, "kind" | "label">} event
 * @param {Info} info
 */
export function eventText(event, info) {
  const words = info.kinds[event.kind]?.words ?? event.kind;
  if (!event.label) return words;
  if (SAYS_ITSELF.has(event.kind)) return plainLabel(event.label);
  if (event.label.toLowerCase().includes(words.toLowerCase())) return event.label;
  return `${words}, ${event.label}`;
}

/**
 * A label without what stands beside it anyway: "(20.0917), 2007-10-01".
 * @param {string} label
 */
function plainLabel(label) {
  return label.replace(/,? \d{4}-\d\d-\d\d.*$/, "").replace(/ \([-\d.]+\)/, "");
}

/**
 * What an event of a series is, its value and date being told besides.
 * @param {TimelineEvent} event
 * @param {Info} info
 */
function shortEvent(event, info) {
  const label = plainLabel(event.label);
  const words = info.kinds[event.kind]?.words ?? event.kind;
  if (SAYS_ITSELF.has(event.kind)) return label || words;
  const change = label.match(/^[-+][\d.]+( %)?/)?.[0];
  return change ? `${words}, ${change.replace("-", "\u2212")}` : words;
}

/**
 * The event at a place of a window, or null.
 * @param {View} view
 * @param {number} place
 * @returns {TimelineEvent | null}
 */
export function eventAt(view, place) {
  let nearest = null;
  for (const event of view.events) {
    const away = Math.abs(event.place - place);
    if (away <= AT && (!nearest || away < Math.abs(nearest.place - place))) nearest = event;
  }
  return nearest;
}

/**
 * The last event that a disk passed on its way between two places of a window, or null.
 * @param {View} view
 * @param {number} from
 * @param {number} to
 * @returns {TimelineEvent | null}
 */
export function eventPassed(view, from, to) {
  const [low, high] = from < to ? [from, to] : [to, from];
  const passed = view.events.filter(({ place }) => place > low && place <= high);
  return (from < to ? passed.at(-1) : passed[0]) ?? null;
}

/**
 * What a person who doesn't see is told of a place: "702.10 dollars, 19 September 2012, peak".
 * @param {View} view
 * @param {number} place
 * @param {Info} info
 */
export function placeText(view, place, info) {
  const at = secondsAt(view, place);
  const here = eventAt(view, place);
  const empty = view.gaps.some(([from, to]) => place > from && place < to);
  const point = empty && !here ? -1 : pointAt(view, here?.time_s ?? at);
  if (point >= 0) {
    const told = [
      valueText(view.points.value[point], info), spokenMoment(view.points.time_s[point], info),
    ];
    if (here) told.push(shortEvent(here, info));
    return told.join(", ");
  }
  const moment = spokenMoment(at, info);
  if (here) return `${moment}, ${eventText(here, info)}`;
  if (empty) return `${moment}, no data`;
  const before = view.events.filter((event) => event.place < place).at(-1);
  return before ? `${moment}, after ${eventText(before, info)}` : moment;
}

/**
 * The value at a place as it is shown; "" where there is none.
 * @param {View} view
 * @param {number} place
 * @param {Info} info
 */
export function valueAt(view, place, info) {
  if (view.gaps.some(([from, to]) => place > from && place < to)) return "";
  const here = eventAt(view, place);
  const point = pointAt(view, here?.time_s ?? secondsAt(view, place));
  return point < 0 ? "" : valueText(view.points.value[point], info);
}

const SCORE = /^\d+-\d+(?= )/;

/**
 * The scores of a match's window in their order, each with the place from which it is so.
 * @param {View} view
 */
export function scoresOf(view) {
  const goals = view.events.filter(({ label }) => SCORE.test(label));
  /** @param {TimelineEvent} event */
  const text = ({ label }) => label.match(SCORE)[0].replace("-", "\u2013");
  const scores = goals.map((goal) => ({ place: goal.place, text: text(goal) }));
  return scores.length > 0 ? [{ place: 0, text: "0\u20130" }, ...scores] : [];
}

/**
 * The score at a place of a match's window; "" before its first goal, and where there is none.
 * @param {View} view
 * @param {number} place
 */
export function scoreAt(view, place) {
  return scoresOf(view).slice(1).filter((one) => one.place <= place + AT).at(-1)?.text ?? "";
}

/**
 * What lies in a window, to somebody who comes to it: span, range, what to look for.
 * @param {View} view
 * @param {Info} info
 */
export function summaryText(view, info) {
  const told = [
    `${info.title}: ${spokenMoment(view.start_s, info)} to ${spokenMoment(view.end_s, info)}`,
  ];
  if (view.points) {
    const [lowest, highest] = rangeOf(view);
    told.push(`from ${valueText(lowest, info)} to ${valueText(highest, info)}`);
  }
  const counts = new Map();
  for (const { kind } of view.events) {
    if (info.kinds[kind].shape !== "bar") counts.set(kind, (counts.get(kind) ?? 0) + 1);
  }
  const kinds = [...counts].map(([kind, count]) => `${info.kinds[kind].words}: ${count}`);
  return [...told, ...kinds].join("; ");
}
