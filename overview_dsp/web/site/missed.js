// What a person missed in a live timeline: new events since the last release, and a visit of them.

import { button } from "./dom.js";
import { positionAt } from "./angle_map.js";
import { eventText } from "./descriptions.js";
import { missed } from "./page_words.js";

/** @import { LiveParts } from "../types" */
/** @typedef {{ kind: string, label: string, change?: [number, string], time_s: number }} NewEvent */

const REST_MS = 1000; // time at each event, in which the disk arrives and rests
const BEYOND = 0.012; // distance beyond an event, so that the disk passes it

export class MissedEvents {
  /**
   * `line` is the status line of the live timeline, which the button follows.
   * @param {LiveParts} parts
   * @param {HTMLElement} line
   */
  constructor(parts, line) {
    this.parts = parts;
    /** @type {NewEvent[]} */
    this.events = [];
    this.visiting = false;
    this.wasTouched = false;
    this.button = button("", () => parts.playback.whenReady(() => this.visit()));
    this.button.id = "missed";
    line.after(this.button);
    this.show();
  }

  show() {
    const count = this.events.length;
    this.button.hidden = count === 0 || this.visiting;
    this.button.textContent = missed(count);
  }

  /**
   * Add a new event, or remove a withdrawn one.
   * @param {string} action "added" or "retracted"
   * @param {NewEvent} event
   */
  change(action, event) {
    const others = this.events.filter((one) => one.kind !== event.kind || one.time_s !== event.time_s);
    this.events = action === "added" ? [...others, event] : others;
    this.show();
  }

  /** Forget the events at the end of a touch: the person was here. */
  afterInput() {
    const touched = this.parts.input.active !== null;
    if (this.wasTouched && !touched && !this.visiting) {
      this.events = [];
      this.show();
    }
    this.wasTouched = touched;
  }

  /** Touch each event in order of time; another input ends the visit. */
  async visit() {
    const { info, input, viewState, announcer, speech, actions } = this.parts;
    const events = [...this.events].sort((one, other) => one.time_s - other.time_s);
    this.visiting = true;
    this.show();
    await viewState.showWhole();
    for (const event of events) {
      input.touchAgain("play", positionAt(viewState.view, event.time_s) + BEYOND);
      const text = eventText(event, info);
      announcer.say(text);
      speech.speak(text);
      actions.wake();
      await new Promise((resolve) => setTimeout(resolve, REST_MS));
      if (input.active !== "play") break;
    }
    this.visiting = false;
    this.events = [];
    input.release("play");
    this.show();
  }
}
