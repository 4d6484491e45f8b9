// The table of all values and events of a window, sortable, and as a CSV file.

import { button, byId, made, on } from "./dom.js";
import { momentText, shortEvent } from "./descriptions.js";
import { valueText } from "./values.js";
import { THINNED } from "./page_words.js";
import { fromTo } from "./words.js";

/** @import { Info, View } from "../types" */

/**
 * A row of the table: time (s), value (undefined in a gap or without values) and events.
 * @typedef {{ time_s: number, value: number | undefined, events: string }} Row
 */

const ROWS = 500; // rows shown at a time

/**
 * Return the rows of a window by time: each value, with the events at its time, and each other event.
 * @param {View} view
 * @param {Info} info
 * @returns {Row[]}
 */
export function rowsOf(view, info) {
  const { time_s: times, value: values } = view.points ?? { time_s: [], value: [] };
  /** @type {Row[]} */
  const rows = times.map((time_s, i) => ({ time_s, value: values[i], events: "" }))
    .filter(({ time_s }) => time_s >= view.start_s && time_s <= view.end_s);
  const microseconds = (/** @type {number} */ seconds) => Math.round(1e6 * seconds);
  const atTime = new Map(rows.map((row) => [microseconds(row.time_s), row]));
  for (const event of view.events) {
    const { time_s } = event;
    const text = shortEvent(event, info);
    const row = atTime.get(microseconds(time_s));
    if (row) row.events += row.events ? `; ${text}` : text;
    else rows.push({ time_s, value: undefined, events: text });
  }
  return rows.sort((a, b) => a.time_s - b.time_s);
}

/**
 * Return rows as CSV (RFC 4180): date and time of a calendar, else seconds.
 * @param {Row[]} rows
 * @param {Info} info
 */
export function csvOf(rows, { start, series }) {
  const quoted = (/** @type {string} */ text) => (/[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
  const zone = start?.match(/(Z|[+-]\d\d:\d\d)$/)?.[0] ?? "";
  const first = start ? Date.parse(`${start.slice(0, start.length - zone.length)}Z`) : 0;
  const when = (/** @type {number} */ seconds) => (start
    ? new Date(first + 1e3 * seconds).toISOString().replace(/(\.000)?Z$/, "") + zone : `${seconds}`);
  const unit = series?.unit ? ` (${series.unit})` : "";
  const head = [start ? "time" : "time_s", ...(series ? [`value${unit}`] : []), "events"];
  const lines = rows.map(({ time_s, value, events }) =>
    [when(time_s), ...(series ? [value ?? ""] : []), events].map((one) => quoted(`${one}`)).join(","));
  return [head.map(quoted).join(","), ...lines, ""].join("\r\n");
}

export class AllValues {
  /** @param {Info} info */
  constructor(info) {
    this.info = info;
    /** @type {Row[]} */
    this.rows = [];
    this.shown = 0;
    this.url = "";
    /** @type {["time_s" | "value" | "events", number]} */
    this.order = ["time_s", 1];
    on("values-more", "click", () => this.showMore());
    on("values", "close", () => URL.revokeObjectURL(this.url));
  }

  /** @param {View} view */
  open(view) {
    const { info } = this;
    this.rows = rowsOf(view, info);
    this.url = URL.createObjectURL(new Blob([csvOf(this.rows, info)], { type: "text/csv" }));
    byId("values-download").href = this.url;
    byId("values-download").download = `${info.title.replace(/[^\p{L}\p{N}]+/gu, "-")}.csv`;
    const isThinned = info.series !== null && !info.series.complete;
    byId("values-note").textContent = `${this.rows.length} rows, `
      + fromTo(momentText(view.start_s, info), momentText(view.end_s, info))
      + (isThinned ? THINNED : "");
    this.sort("time_s", 1);
    byId("values").showModal();
    byId("values-title").focus();
  }

  /**
   * @param {"time_s" | "value" | "events"} column
   * @param {number} direction
   */
  sort(column, direction) {
    this.order = [column, direction];
    const key = (/** @type {Row} */ row) => row[column] ?? -Infinity;
    this.rows.sort((a, b) => (key(a) < key(b) ? -direction : key(a) > key(b) ? direction : a.time_s - b.time_s));
    const names = { time_s: "Time", value: "Value", events: "Events" };
    const columns = /** @type {(keyof typeof names)[]} */ (
      Object.keys(names).filter((name) => name !== "value" || this.info.series));
    byId("values-head").replaceChildren(...columns.map((name) => {
      const isSorted = name === column;
      const ariaSort = isSorted ? (direction > 0 ? "ascending" : "descending") : "none";
      return made("th", { scope: "col", ariaSort }, button("", () => {
        this.sort(name, isSorted ? -direction : 1);
        byId("values-head").querySelectorAll("button")[columns.indexOf(name)].focus();
      }, names[name]));
    }));
    byId("values-rows").replaceChildren();
    this.shown = 0;
    this.showMore();
  }

  showMore() {
    const { info } = this;
    const body = byId("values-rows");
    for (const { time_s, value, events } of this.rows.slice(this.shown, this.shown + ROWS)) {
      const texts = [momentText(time_s, info), ...(info.series ? [valueText(value, info)] : []), events];
      body.append(made("tr", {}, ...texts.map((text) => made("td", {}, text))));
    }
    this.shown = Math.min(this.shown + ROWS, this.rows.length);
    byId("values-more").hidden = this.shown === this.rows.length;
  }
}
