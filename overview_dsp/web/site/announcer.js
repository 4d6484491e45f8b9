// The page's polite live region: screen readers speak what a key, a button or a list has done.

import { byId } from "./dom.js";

/** @import { Slider } from "./slider.js" */

export class Announcer {
  /**
   * `region` is the live region; the value text of `slider` is spoken while it has the focus.
   * @param {HTMLElement} region
   * @param {Slider} slider
   */
  constructor(region, slider) {
    this.region = region;
    this.slider = slider;
  }

  /** @param {string} text */
  say(text) {
    // a changed space, since the same text again would not be spoken
    const isSame = this.region.textContent === text;
    this.region.textContent = isSame ? `${text}\u00a0` : text;
  }

  /**
   * Report a new position as the slider's value, or in the region if the focus is elsewhere.
   * @param {number} position
   * @param {string} text
   */
  position(position, text) {
    this.slider.setValue(position, text);
    if (document.activeElement !== byId("slider")) this.say(text);
  }
}
