// What a key or a button does with the hand: from place to place, from event to event.

import { extremeOf } from "./values.js";
import { placeText, summaryText } from "./words.js";

const NEAR = 1e-6; // of a window or s: the same place

/** @import { Info, TimelineEvent } from "../types" */
/** @import { Hand } from "./hand.js" */
/** @import { Shown } from "./shown.js" */
/** @import { Speech } from "./speech.js" */

export class Walk {
  /**
   * `shown`: the window under the hand (`Shown`); `speech` says where the hand has come to.
   * @param {Hand} hand
   * @param {Shown} shown
   * @param {Speech} speech
   * @param {Info} info
   */
  constructor(hand, shown, speech, info) {
    this.hand = hand;
    this.shown = shown;
    this.speech = speech;
    this.info = info;
  }

  /** @param {number} by */
  move(by) {
    const { place } = this.hand;
    const wanted = place + by;
    const side = Math.sign(by);
    if ((wanted > 1 && place === 1) || (wanted < 0 && place === 0)) this.shown.beside(side);
    else {
      this.hand.hold("keys", wanted);
      this.sayPlace();
    }
  }

  /** @param {number} place */
  to(place) {
    this.hand.setDown("keys", place);
    this.sayPlace();
  }

  tap() {
    this.hand.tap("keys", this.hand.place);
    this.sayPlace();
  }

  letGo() {
    this.hand.release("keys");
  }

  first() {
    this.to(0);
  }

  last() {
    this.to(1);
  }

  highest() {
    this.to(extremeOf(this.shown.view, 1));
  }

  lowest() {
    this.to(extremeOf(this.shown.view, -1));
  }

  /** What lies here and what to look for, said. */
  summary() {
    this.speech.say(summaryText(this.shown.view, this.info));
  }

  /**
   * To the next (1) or the last (-1) event, in this window or beyond its end.
   * @param {number} direction
   */
  async event(direction) {
    const after = (/** @type {TimelineEvent} */ event) => (event.place - this.hand.place) * direction > NEAR;
    let found = this.shown.view.events.filter(after);
    if (found.length === 0) {
      const now = this.shown.moment;
      if (!(await this.shown.beside(direction))) return;
      found = this.shown.view.events.filter((event) => (event.time_s - now) * direction > NEAR);
    }
    const next = direction > 0 ? found[0] : found.at(-1);
    if (next) this.to(next.place);
  }

  sayPlace() {
    this.speech.say(placeText(this.shown.view, this.hand.place, this.info));
  }
}
