// The pad: where a person feels a stimulus by the hand, a slider for assistive technology. It tells
// nothing of the timeline unless the condition is seen.

import { SampleClock } from "./clock.js";
import { boxOf, View } from "./drawing.js";
import { CombinedInput } from "./combined_input.js";
import { button, make } from "./make.js";
import { Strokes } from "./strokes.js";
import { listenToTouch } from "./touch.js";

const STEP = 0.01;
const PAGE = 0.1;

/** Whom a wrist moves between two trials. */
export const NOBODY = { moveTo: () => {}, release: () => {} };

export class Pad {
  /**
   * `input`: the hand that the condition has (keys always may); `kinds`: of study.json; `twist`: a
   * Twist, which stays on from trial to trial.
   */
  constructor({ input, label, kinds, twist, onfault }) {
    this.input = input;
    this.twist = twist;
    this.kinds = kinds;
    this.onfault = onfault;
    this.presentation = null;
    this.place = 0; // where the hand was last
    this.sources = new Set(); // hands that were used
    this.felt = false; // whether it was touched since the presentation began
    /** Called when a hand first feels a presentation. */
    this.onfelt = () => {};
    this.view = new View(kinds);
    this.finger = make("i", { class: "finger", hidden: true });
    this.slider = make("div", {
      class: "pad", role: "slider", tabindex: 0, "aria-label": label, "aria-valuemin": 0,
      "aria-valuemax": 100, "aria-valuenow": 0, "aria-valuetext": "at the start",
    }, this.view.element, this.finger);
    this.element = make("div", { class: "felt" }, this.slider, this.hint());
    this.left = () => document.hidden && !this.twist.on && this.hand?.releaseAll();
    document.addEventListener("visibilitychange", this.left);
    this.listen();
  }

  hint() {
    const words = {
      touch: "Drag along the field. Keys: arrows, Page keys, Home, End, Space, Escape.",
      any: "Drag along the field, or use the arrow keys.",
      keys: "Use the arrow keys, Page keys, Home, End; Space taps, Escape lets go.",
      twist: "Turn on Twist and roll the phone, face up to face down. Keys work too.",
    };
    const wrist = this.input === "twist" || (this.input === "any" && navigator.maxTouchPoints > 0);
    this.toggle = wrist
      ? button("Twist", () => this.toggleTwist(), { "aria-pressed": this.twist.on }) : null;
    return make("div", { class: "hint" }, make("p", { text: words[this.input] }), this.toggle);
  }

  /** Feel a presentation from now on; `view` is drawn, null in the dark. */
  begin(presentation, view) {
    this.release();
    this.presentation = presentation;
    this.view.show(view);
    this.felt = false;
    this.clock = new SampleClock(presentation.rate);
    const send = (place, touching, sample) => presentation.control(place, touching, sample);
    this.hand = new CombinedInput(new Strokes(this.clock, send));
    this.hand.onchange = () => this.moved();
    if (this.toggle) this.twist.input = this.hand;
    this.follow(presentation);
  }

  /** Let go; the disk runs back. */
  release() {
    this.hand?.releaseAll();
  }

  end() {
    this.release();
    this.twist.input = NOBODY;
    this.presentation = null;
    this.view.end();
    document.removeEventListener("visibilitychange", this.left);
  }

  /** Ask the audio thread where the disk is, every frame. */
  async follow(presentation) {
    while (this.presentation === presentation && !presentation.stopped) {
      const { clock, cursor } = await presentation.look();
      this.clock.addReading(clock, performance.now());
      this.show(cursor);
      await new Promise((resolve) => {
        requestAnimationFrame(resolve);
      });
    }
  }

  moved() {
    const { active: holder, position: place } = this.hand;
    if (holder === null) return;
    this.place = place;
    this.sources.add(holder);
    const percent = Math.round(100 * place);
    this.slider.setAttribute("aria-valuenow", percent);
    this.slider.setAttribute("aria-valuetext", `${percent} percent${this.nearby(place)}`);
    if (this.felt) return;
    this.felt = true;
    this.onfelt();
  }

  /** What a seen condition says of a place in words. */
  nearby(place) {
    const near = this.view.view?.events.find((event) => Math.abs(event.position - place) < STEP / 2);
    return near ? `, ${this.kinds[near.kind].name}` : "";
  }

  show(cursor) {
    const { x } = boxOf(this.slider.clientWidth, this.slider.clientHeight);
    this.finger.hidden = !this.felt;
    this.finger.classList.toggle("holding", this.hand.active !== null);
    this.finger.style.transform = `translateX(${x(this.place).toFixed(1)}px)`;
    this.view.at(cursor);
  }

  // --- hands ------------------------------------------------------------------------------------

  listen() {
    const may = (input) => this.presentation !== null && [input, "any"].includes(this.input);
    // a hand of its own in between, as each presentation has another
    const touch = {
      moveTo: (source, place, time) => may("touch") && this.hand.moveTo(source, place, time),
      release: (source, time) => may("touch") && this.hand.release(source, time),
    };
    listenToTouch(this.slider, touch, {
      positionOf: ({ clientX }) => {
        const { left, width, height } = this.slider.getBoundingClientRect();
        return boxOf(width, height).place(clientX - left);
      },
      ontap: () => {},
      onpinch: () => {},
      onfirst: () => {},
    });
    const to = (place) => this.hand.moveTo("keys", place);
    const by = (step) => ({ shiftKey }) => to(this.hand.position + step * (shiftKey ? 10 : 1));
    const keys = {
      ArrowRight: by(STEP), ArrowUp: by(STEP), ArrowLeft: by(-STEP), ArrowDown: by(-STEP),
      PageUp: by(PAGE), PageDown: by(-PAGE),
      Home: () => to(0), End: () => to(1),
      " ": ({ repeat }) => repeat || this.hand.tap("keys", this.hand.position),
      Escape: () => this.hand.release("keys"),
    };
    this.slider.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.altKey || event.metaKey || !Object.hasOwn(keys, event.key)) return;
      event.preventDefault();
      if (this.presentation !== null) keys[event.key](event);
    });
    this.slider.addEventListener("blur", () => this.hand?.release("keys"));
  }

  async toggleTwist() {
    const { twist } = this;
    twist.onsilent = (line) => {
      twist.end();
      this.toggle.setAttribute("aria-pressed", "false");
      this.onfault(line);
    };
    try {
      if (twist.on) twist.end();
      else await twist.begin();
    } catch (error) {
      this.onfault(error.message);
    }
    this.toggle.setAttribute("aria-pressed", String(twist.on));
  }
}
