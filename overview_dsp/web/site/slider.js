// Texts of the picture: the slider's value for assistive technology, and a line above the picture.

import { secondsAt } from "./angle_map.js";
import { byId, made } from "./dom.js";
import {
  eventAt, gapText, momentText, numberAt, positionText, scoreAt, shortEvent, summaryText,
} from "./descriptions.js";
import { markIcon } from "./legend.js";
import { markOf } from "./marks.js";
import { NO_DATA } from "./words.js";

/** @import { Info, TimelineEvent, View } from "../types" */

const EVERY_MS = 100; // minimum time between two layouts of text
const EVERY_FRAMES = 6; // minimum number of frames between them on a slow device
const LATE_MS = 400; // maximum delay of a text

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
      setText("clock", momentText(here?.time_s ?? secondsAt(view, position), info));
      const number = numberAt(view, position, info);
      setText("unit", number && number !== NO_DATA ? info.series?.unit ?? "" : "");
      if (info.series) setText("number", number);
      else this.showScore(scoreAt(view, position));
      this.showEvent(here, info, number === NO_DATA ? gapText(view, position, info) : "");
    }
  }

  /**
   * Show a score, each digit in the colour of its team.
   * @param {string} score
   */
  showScore(score) {
    if (byId("number").textContent === score) return;
    const [one, two] = score.split("\u2013").map((digits, i) =>
      made("span", { className: i === 0 ? "one" : "two" }, digits));
    byId("number").replaceChildren(...(two ? [one, "\u2013", two] : []));
  }

  /**
   * Show an event with its mark, or another text where there is none.
   * @param {TimelineEvent | null} event
   * @param {Info} info
   * @param {string} other
   */
  showEvent(event, info, other) {
    const text = event ? shortEvent(event, info) : other;
    if (byId("event").textContent === text) return;
    const marks = event ? [markIcon(markOf(event.kind, info.kinds[event.kind], event.side))] : [];
    byId("event").replaceChildren(...marks, text);
  }
}

/**
 * @param {"clock" | "number" | "unit" | "event"} id
 * @param {string} text
 */
function setText(id, text) {
  const element = byId(id);
  if (element.textContent !== text) element.textContent = text;
}
