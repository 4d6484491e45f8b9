// Ticks of the time axis, at round times; of a calendar at midnights and the beginnings of months and years.

import { dates, HOURS, LONG_S, momentText, SECONDS, startOf } from "./descriptions.js";
import { LOCALES } from "./values.js";

/** @import { Info, View } from "../types" */
/** @typedef {{ at: number, text: string, number: number }} Tick time (s), label, number of the span that begins */

const DAY_S = 86400;
const STEPS_S = [1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 10800, 21600, 43200];
const ROUND = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 1e4, 1e5, 1e6, 1e7, 1e8];
const YEAR_S = 365.25 * DAY_S;
const MONDAY_S = 4 * DAY_S; // the first one of 1970: weeks begin there
const MOST = 400; // ticks that are tried

const YEARS = dates({ year: "numeric" });
const MONTHS = dates({ month: "short" });
const DATES = dates({ day: "numeric", month: "short" });
const WEEKDAYS = dates({ weekday: "short" });
/** @param {string} unit */
const counted = (unit) => new Intl.NumberFormat(LOCALES, { style: "unit", unit, unitDisplay: "long" });
const [DAYS_LONG, YEARS_LONG] = ["day", "year"].map(counted);

/**
 * Return the ticks of the smallest round step at which the labels fit, by `fits(label, count)`.
 * @param {View} view
 * @param {Info} info
 * @param {(text: string, count: number) => boolean} fits
 * @returns {Tick[]}
 */
export function ticksOf(view, info, fits) {
  const start = startOf(info);
  /** @type {(step: number, text: (at: number) => string) => [number, () => Tick[]]} */
  const even = (step, text) => [step, () => evenTicks(view, step, start === null ? 0 : start / 1e3 - MONDAY_S, text)];
  /** @type {(months: number) => [number, () => Tick[]]} */
  const monthly = (months) => [months * (YEAR_S / 12), () => calendarTicks(view, start ?? 0, months)];
  /** @type {[number, () => Tick[]][]} */
  const steps = start === null
    ? [
      ...STEPS_S.map((step) => even(step, (at) => elapsedText(at, step, info))),
      ...ROUND.slice(0, 8).map((days) => even(days * DAY_S, (at) => DAYS_LONG.format(at / DAY_S))),
      ...ROUND.map((years) => even(years * YEAR_S, (at) => YEARS_LONG.format(at / YEAR_S))),
    ]
    : [
      ...[...STEPS_S, DAY_S, 2 * DAY_S, 7 * DAY_S, 14 * DAY_S]
        .map((step) => even(step, (at) => clockText(start + 1e3 * at, step, info))),
      ...[1, 3, 6].map(monthly), ...ROUND.map((years) => monthly(12 * years)),
    ];
  /** @type {Tick[]} */
  let before = [];
  for (const [step, make] of steps) {
    const count = (view.end_s - view.start_s) / step;
    if (count > MOST) continue;
    const ticks = make();
    if (ticks.length < 2 && before.length > ticks.length) return before; // labels without room are left out
    const longest = ticks.reduce((most, { text }) => (text.length > most.length ? text : most), "");
    if (fits(longest, count)) return ticks;
    before = ticks;
  }
  return before;
}

/**
 * Return the time (s) since the start in whole minutes or hours, or with its seconds.
 * @param {number} at
 * @param {number} step s
 * @param {Info} info
 */
function elapsedText(at, step, info) {
  if (step % 3600 === 0 && info.duration_s >= 3 * 3600) return `${at / 3600} h`;
  return step % 60 === 0 && info.duration_s < 3 * 3600 ? `${at / 60}\u2032` : momentText(at, info);
}

/**
 * Return hours and minutes, or the day at midnight.
 * @param {number} moment ms
 * @param {number} step s
 * @param {Info} info
 */
function clockText(moment, step, { duration_s }) {
  if (moment % (1e3 * DAY_S) === 0) return (duration_s <= LONG_S ? WEEKDAYS : DATES).format(moment);
  return (step < 60 ? SECONDS : HOURS).format(moment);
}

/**
 * @param {View} view
 * @param {number} step
 * @param {number} origin time (s) from a tick to the timeline's start
 * @param {(at: number) => string} text
 */
function evenTicks({ start_s, end_s }, step, origin, text) {
  const ticks = [];
  for (let number = Math.ceil((start_s + origin) / step); number * step - origin <= end_s; number += 1) {
    const at = number * step - origin;
    ticks.push({ at, text: text(at), number });
  }
  return ticks;
}

/**
 * @param {View} view
 * @param {number} start of the timeline, ms
 * @param {number} months
 */
function calendarTicks({ start_s, end_s }, start, months) {
  const first = new Date(start + 1e3 * start_s);
  const ticks = [];
  for (let number = Math.floor((12 * first.getUTCFullYear() + first.getUTCMonth()) / months); ; number += 1) {
    const moment = new Date(0);
    moment.setUTCFullYear(Math.floor((number * months) / 12), (number * months) % 12, 1);
    const at = (moment.getTime() - start) / 1e3;
    if (!(at <= end_s)) return ticks;
    const isYear = moment.getUTCMonth() === 0;
    if (at >= start_s) ticks.push({ at, text: (isYear ? YEARS : MONTHS).format(moment), number });
  }
}
