// The timeline as a slider for assistive technology: its value says when, and what happened there.

import { eventAt, eventText, momentText, placeText, secondsAt } from "./words.js";

export class Slider {
  constructor(element, clock, event) {
    this.element = element;
    this.clock = clock;
    this.event = event;
    this.shown = "";
  }

  /** The finger is at `place` of a window; the disk at `cursor`. */
  show(view, place, cursor, info) {
    const text = placeText(view, place, info);
    if (text !== this.text) {
      this.element.setAttribute("aria-valuenow", (100 * place).toFixed(1));
      this.element.setAttribute("aria-valuetext", text);
      this.text = text;
    }
    const moment = momentText(secondsAt(view, cursor), info);
    const here = eventAt(view, cursor);
    const label = here ? eventText(here, info) : "";
    if (moment + label !== this.shown) {
      this.shown = moment + label;
      this.clock.textContent = moment;
      this.event.textContent = label;
    }
  }
}
