// Movements by keys and buttons, between positions and events.

import { positionAt } from "./angle_map.js";
import { positionText, spokenMoment, summaryText } from "./descriptions.js";
import { allStops, eventStops, nextStop, valueStops } from "./stops.js";
import { extremeOf } from "./values.js";
import { eventCount, NO_MORE_DETAIL, NOTHING_AFTER, NOTHING_BEFORE, tapAt, WHOLE } from "./page_words.js";
import { fromTo } from "./words.js";

/** @import { Info, View } from "../types" */
/** @import { Announcer } from "./announcer.js" */
/** @import { CombinedInput } from "./combined_input.js" */
/** @import { ViewState } from "./view_state.js" */
/** @import { Speech } from "./speech.js" */

export class Navigation {
  /**
   * `viewState` is the visible window; `speech` and `announcer` report each new position.
   * @param {CombinedInput} input
   * @param {ViewState} viewState
   * @param {Speech} speech
   * @param {Announcer} announcer
   * @param {Info} info
   */
  constructor(input, viewState, speech, announcer, info) {
    this.input = input;
    this.viewState = viewState;
    this.speech = speech;
    this.announcer = announcer;
    this.info = info;
  }

  /**
   * Move by a share of the window.
   * @param {number} by
   */
  async move(by) {
    const { position } = this.input;
    const target = position + by;
    if ((target > 1 && position === 1) || (target < 0 && position === 0)) {
      if (!(await this.viewState.shift(Math.sign(by)))) this.reportEnd(by);
      return;
    }
    this.input.moveTo("keys", target);
    this.reportPosition();
  }

  /**
   * Move to the next (1) or previous (-1) value or event; without values, to events and even steps.
   * @param {number} direction
   */
  step(direction) {
    return this.toStop(allStops, direction, true);
  }

  /** @param {number} direction */
  toValue(direction) {
    return this.toStop(valueStops, direction);
  }

  /** @param {number} direction */
  toEvent(direction) {
    return this.toStop(eventStops, direction);
  }

  /**
   * Move to the next (1) or previous (-1) of some stops, also beyond the window.
   * @param {(view: View) => number[]} stopsOf
   * @param {number} direction
   * @param {boolean} isStep whether the touch continues, as of a pulled disk, instead of a new one
   */
  async toStop(stopsOf, direction, isStep = false) {
    let next = nextStop(stopsOf(this.viewState.view), this.viewState.reading, direction);
    if (next === undefined) {
      const now = this.viewState.moment;
      if (await this.viewState.shift(direction)) {
        const { view } = this.viewState;
        await this.viewState.pointsLoaded;
        next = nextStop(stopsOf(view), positionAt(view, now), direction);
      }
    }
    if (next === undefined) {
      this.reportEnd(direction);
      return;
    }
    if (isStep) this.input.moveTo("keys", next);
    else this.input.touchAgain("keys", next);
    this.reportPosition(!isStep);
  }

  /**
   * Zoom in (1) or out (-1), and report the new window.
   * @param {number} direction
   */
  async zoom(direction) {
    if (await this.viewState.zoom(direction)) this.reportWindow();
    else this.announcer.say(direction > 0 ? NO_MORE_DETAIL : WHOLE);
  }

  /** Show the whole timeline, and report it. */
  async showWhole() {
    if (await this.viewState.showWhole()) this.reportWindow();
  }

  reportWindow() {
    const { start_s, end_s, events } = this.viewState.view;
    const [from, to] = [start_s, end_s].map((one) => spokenMoment(one, this.info));
    this.announcer.say(`${fromTo(from, to)}, ${eventCount(events.length)}`);
  }

  /** @param {number} direction */
  reportEnd(direction) {
    const text = direction > 0 ? NOTHING_AFTER : NOTHING_BEFORE;
    this.announcer.say(text);
    this.speech.speak(text);
  }

  /** @param {number} position */
  to(position) {
    this.input.touchAgain("keys", position);
    this.reportPosition();
  }

  tap() {
    this.input.tap("keys", this.input.position);
    this.announcer.say(tapAt(positionText(this.viewState.view, this.input.position, this.info)));
    this.speakPosition();
  }

  release() {
    this.input.release("keys");
  }

  toFirst() {
    this.to(0);
  }

  toLast() {
    this.to(1);
  }

  toHighest() {
    this.to(extremeOf(this.viewState.view, 1));
  }

  toLowest() {
    this.to(extremeOf(this.viewState.view, -1));
  }

  /** Speak a summary of the window. */
  speakSummary() {
    this.speech.speak(summaryText(this.viewState.view, this.info));
  }

  /** Report the position to assistive technology and by speech. */
  reportPosition(withValue = true) {
    const { position } = this.input;
    const text = positionText(this.viewState.view, position, this.info, withValue);
    this.announcer.position(position, text);
    this.speech.speak(text);
  }

  speakPosition() {
    this.speech.speak(positionText(this.viewState.view, this.input.position, this.info));
  }
}
