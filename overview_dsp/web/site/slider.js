// What the picture shows, in words: the timeline as a slider for assistive technology, whose value
// says what is there, and a line of text above the picture.

import { secondsAt } from "./angle_map.js";
import {
  eventAt, eventText, momentText, placeText, scoreAt, summaryText, valueAt,
} from "./words.js";

/** @import { Info, View } from "../types" */

const EVERY_MS = 100; // text is laid out anew each time; nobody reads faster
const EVERY_FRAMES = 6; // nor is it laid out more often where frames are slow,
const LATE_MS = 400; // but no later than this
const MOST = 14; // characters in large type beside a value

export class Slider {
  /**
   * `parts`: the elements slider, clock, value, event, summary.
   * @param {Record<string, HTMLElement>} parts
   */
  constructor(parts) {
    this.parts = parts;
    /** @type {any[]} */
    this.at = [];
    this.shown = -Infinity;
    this.frames = 0; // since then
  }

  /**
   * The finger is at `place` of a window; the disk at `cursor`.
   * @param {View} view
   * @param {number} place
   * @param {number} cursor
   * @param {Info} info
   */
  show(view, place, cursor, info, now = performance.now()) {
    this.frames += 1;
    const since = now - this.shown;
    if (since < EVERY_MS || (since < LATE_MS && this.frames < EVERY_FRAMES)) return;
    this.shown = now;
    this.frames = 0;
    const { slider, clock, value, event } = this.parts;
    const [oldView, oldPlace, oldCursor, oldPoints] = this.at;
    const other = view !== oldView || view.points !== oldPoints;
    this.at = [view, place, cursor, view.points];
    if (other) this.parts.summary.textContent = summaryText(view, info);
    if (other || place !== oldPlace) {
      slider.setAttribute("aria-valuenow", (100 * place).toFixed(1));
      slider.setAttribute("aria-valuetext", placeText(view, place, info));
    }
    if (other || cursor !== oldCursor) {
      const here = eventAt(view, cursor);
      const moment = momentText(secondsAt(view, cursor), info);
      set(clock, "textContent", moment);
      clock.classList.toggle("long", moment.length > MOST);
      set(value, "textContent", valueAt(view, cursor, info) || scoreAt(view, cursor));
      set(event, "textContent", here ? eventText(here, info) : "");
    }
  }
}

/**
 * @param {any} element
 * @param {string} property
 * @param {string} text
 */
function set(element, property, text) {
  if (element[property] !== text) element[property] = text;
}
