// Texts of the picture: the slider's value for assistive technology, and a line above the picture.

import { secondsAt } from "./angle_map.js";
import {
  eventAt, momentText, positionText, scoreAt, shortEvent, summaryText, valueAt,
} from "./descriptions.js";

/** @import { Info, View } from "../types" */

const EVERY_MS = 100; // minimum time between two layouts of text
const EVERY_FRAMES = 6; // minimum number of frames between them on a slow device
const LATE_MS = 400; // maximum delay of a text
const MOST = 14; // characters in large type beside a value

export class Slider {
  /**
   * `parts`: the elements slider, clock, value, event, summary.
   * @param {Record<string, any>} parts
   */
  constructor(parts) {
    this.parts = parts;
    /** @type {any[]} */
    this.at = []; // view, cursor and points of the last update
    this.position = NaN; // of the slider's text
    this.updatedAt = -Infinity;
    this.frames = 0; // since the last update
  }

  /**
   * Set the slider's value for assistive technology.
   * @param {number} position
   * @param {string} text
   */
  setValue(position, text) {
    this.position = position;
    this.parts.slider.value = (100 * position).toFixed(1);
    this.parts.slider.setAttribute("aria-valuetext", text);
  }

  /**
   * Update the texts for the position that is read out.
   * @param {View} view
   * @param {number} position
   * @param {Info} info
   */
  show(view, position, info, now = performance.now()) {
    this.frames += 1;
    const since = now - this.updatedAt;
    if (since < EVERY_MS || (since < LATE_MS && this.frames < EVERY_FRAMES)) return;
    this.updatedAt = now;
    this.frames = 0;
    const { clock, value, event } = this.parts;
    const [oldView, oldPosition, oldPoints] = this.at;
    const other = view !== oldView || view.points !== oldPoints;
    this.at = [view, position, view.points];
    if (other) this.parts.summary.textContent = summaryText(view, info);
    if (other || position !== this.position) this.setValue(position, positionText(view, position, info));
    if (other || position !== oldPosition) {
      const here = eventAt(view, position);
      const moment = momentText(here?.time_s ?? secondsAt(view, position), info);
      set(clock, "textContent", moment);
      clock.classList.toggle("long", moment.length > MOST);
      set(value, "textContent", valueAt(view, position, info) || scoreAt(view, position));
      set(event, "textContent", here ? shortEvent(here, info) : "");
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
