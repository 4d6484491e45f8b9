// Texts of the picture: the slider's value for assistive technology, and a line above the picture.

import { secondsAt } from "./angle_map.js";
import { byId } from "./dom.js";
import {
  eventAt, momentText, positionText, scoreAt, shortEvent, summaryText, valueAt,
} from "./descriptions.js";

/** @import { Info, View } from "../types" */

const EVERY_MS = 100; // minimum time between two layouts of text
const EVERY_FRAMES = 6; // minimum number of frames between them on a slow device
const LATE_MS = 400; // maximum delay of a text
const MOST = 14; // characters in large type beside a value

export class Slider {
  constructor() {
    /** @type {[View, number, View["points"]] | []} */
    this.at = []; // view, position and points of the last update
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
    byId("slider").value = (100 * position).toFixed(1);
    byId("slider").setAttribute("aria-valuetext", text);
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
    const [oldView, oldPosition, oldPoints] = this.at;
    const other = view !== oldView || view.points !== oldPoints;
    this.at = [view, position, view.points];
    if (other) byId("summary").textContent = summaryText(view, info);
    if (other || position !== this.position) this.setValue(position, positionText(view, position, info));
    if (other || position !== oldPosition) {
      const here = eventAt(view, position);
      const moment = momentText(here?.time_s ?? secondsAt(view, position), info);
      setText("clock", moment);
      byId("clock").classList.toggle("long", moment.length > MOST);
      setText("value", valueAt(view, position, info) || scoreAt(view, position));
      setText("event", here ? shortEvent(here, info) : "");
    }
  }
}

/**
 * @param {"clock" | "value" | "event"} id
 * @param {string} text
 */
function setText(id, text) {
  const element = byId(id);
  if (element.textContent !== text) element.textContent = text;
}
