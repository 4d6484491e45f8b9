// The timeline as a slider for assistive technology: its value says when, and what happened there.

import { eventAt, eventText, momentText, placeText, secondsAt } from "./words.js";

export class Slider {
  constructor(element, clock, event) {
    this.element = element;
    this.clock = clock;
    this.event = event;
    this.at = [];
  }

  /** The finger is at `place` of a window; the disk at `cursor`. */
  show(view, place, cursor, info) {
    const [oldView, oldPlace, oldCursor] = this.at;
    this.at = [view, place, cursor];
    if (view !== oldView || place !== oldPlace) {
      this.element.setAttribute("aria-valuenow", (100 * place).toFixed(1));
      this.element.setAttribute("aria-valuetext", placeText(view, place, info));
    }
    if (view !== oldView || cursor !== oldCursor) {
      const here = eventAt(view, cursor);
      set(this.clock, "textContent", momentText(secondsAt(view, cursor), info));
      set(this.event, "textContent", here ? eventText(here, info) : "");
    }
  }
}

function set(element, property, text) {
  if (element[property] !== text) element[property] = text;
}
