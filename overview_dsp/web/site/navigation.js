// Movements by keys and buttons, between positions and events.

import { extremeOf } from "./values.js";
import { positionText, summaryText } from "./descriptions.js";

const NEAR = 1e-6; // tolerance, in s or as a share of the window

/** @import { Info, TimelineEvent } from "../types" */
/** @import { CombinedInput } from "./combined_input.js" */
/** @import { ViewState } from "./view_state.js" */
/** @import { Speech } from "./speech.js" */

export class Navigation {
  /**
   * `viewState` is the visible window; `speech` speaks each new position.
   * @param {CombinedInput} input
   * @param {ViewState} viewState
   * @param {Speech} speech
   * @param {Info} info
   */
  constructor(input, viewState, speech, info) {
    this.input = input;
    this.viewState = viewState;
    this.speech = speech;
    this.info = info;
  }

  /** @param {number} by */
  move(by) {
    const { position } = this.input;
    const target = position + by;
    const side = Math.sign(by);
    if ((target > 1 && position === 1) || (target < 0 && position === 0)) this.viewState.shift(side);
    else {
      this.input.moveTo("keys", target);
      this.speakPosition();
    }
  }

  /** @param {number} position */
  to(position) {
    this.input.touchAgain("keys", position);
    this.speakPosition();
  }

  tap() {
    this.input.tap("keys", this.input.position);
    this.speakPosition();
  }

  release() {
    this.input.release("keys");
  }

  first() {
    this.to(0);
  }

  last() {
    this.to(1);
  }

  highest() {
    this.to(extremeOf(this.viewState.view, 1));
  }

  lowest() {
    this.to(extremeOf(this.viewState.view, -1));
  }

  /** Speak a summary of the window. */
  speakSummary() {
    this.speech.speak(summaryText(this.viewState.view, this.info));
  }

  /**
   * Move to the next (1) or previous (-1) event, also beyond the window.
   * @param {number} direction
   */
  async toEvent(direction) {
    const after = (/** @type {TimelineEvent} */ event) => (event.position - this.input.position) * direction > NEAR;
    let found = this.viewState.view.events.filter(after);
    if (found.length === 0) {
      const now = this.viewState.moment;
      if (!(await this.viewState.shift(direction))) return;
      found = this.viewState.view.events.filter((event) => (event.time_s - now) * direction > NEAR);
    }
    const next = direction > 0 ? found[0] : found.at(-1);
    if (next) this.to(next.position);
  }

  speakPosition() {
    this.speech.speak(positionText(this.viewState.view, this.input.position, this.info));
  }
}
