// Pad for exploring a stimulus by touch, twist or keys. For assistive technology it is a slider. Only
// visual conditions show the timeline.

import { SampleClock } from "./clock.js";
import { boxOf, View } from "./drawing.js";
import { CombinedInput } from "./combined_input.js";
import { button, make } from "./make.js";
import { Strokes } from "./strokes.js";
import { listenToTouch } from "./touch.js";

const STEP = 0.01;
const PAGE = 0.1;

/** Receiver of twist events between trials. */
export const NO_INPUT = { moveTo: () => {}, release: () => {} };

export class Pad {
  /**
   * `input`: input of the condition, keys are always allowed; `kinds`: from study.json; `twist`: a
   * Twist, which stays active between trials.
   */
  constructor({ input, label, kinds, twist, onfault }) {
    this.input = input;
    this.twist = twist;
    this.kinds = kinds;
    this.onfault = onfault;
    this.presentation = null;
    this.position = 0; // last input position
    this.sources = new Set(); // inputs that were used
    this.touched = false; // since the presentation began
    /** Called at the first touch of a presentation. */
    this.ontouched = () => {};
    this.view = new View(kinds);
    this.finger = make("i", { class: "finger", hidden: true });
    this.slider = make("div", {
      class: "pad", role: "slider", tabindex: 0, "aria-label": label, "aria-valuemin": 0,
      "aria-valuemax": 100, "aria-valuenow": 0, "aria-valuetext": "at the start",
    }, this.view.element, this.finger);
    this.element = make("div", { class: "felt" }, this.slider, this.hint());
    this.connect(new SampleClock(1), () => {});
    this.left = () => document.hidden && !this.twist.on && this.combined.releaseAll();
    document.addEventListener("visibilitychange", this.left);
    this.listen();
  }

  hint() {
    const hints = {
      touch: "Drag along the field. Keys: arrows, Page keys, Home, End, Space, Escape.",
      any: "Drag along the field, or use the arrow keys.",
      keys: "Use the arrow keys, Page keys, Home, End; Space taps, Escape releases.",
      twist: "Turn on Twist and roll the phone, face up to face down. Keys work too.",
    };
    const canTwist = this.input === "twist" || (this.input === "any" && navigator.maxTouchPoints > 0);
    this.toggle = canTwist
      ? button("Twist", () => this.toggleTwist(), { "aria-pressed": this.twist.on }) : null;
    return make("div", { class: "hint" }, make("p", { text: hints[this.input] }), this.toggle);
  }

  /** Create the input that sends its movements to `send`. */
  connect(clock, send) {
    this.clock = clock;
    /** @type {CombinedInput} */
    this.combined = new CombinedInput(new Strokes(clock, send));
    this.combined.onchange = () => this.moved();
  }

  /** Connect a presentation; `view` is drawn unless it is null. */
  begin(presentation, view) {
    this.release();
    this.presentation = presentation;
    this.view.show(view);
    this.touched = false;
    const send = (place, touching, sample) => presentation.control(place, touching, sample);
    this.connect(new SampleClock(presentation.rate), send);
    if (this.toggle) this.twist.input = this.combined;
    this.follow(presentation);
  }

  /** Release; the disk springs back. */
  release() {
    this.combined.releaseAll();
  }

  end() {
    this.release();
    this.twist.input = NO_INPUT;
    this.presentation = null;
    this.view.end();
    document.removeEventListener("visibilitychange", this.left);
  }

  /** Read the disk's state from the audio thread in every frame. */
  async follow(presentation) {
    while (this.presentation === presentation && !presentation.stopped) {
      const { clock, cursor } = await presentation.readState();
      this.clock.addReading(clock, performance.now());
      this.show(cursor);
      await new Promise((resolve) => {
        requestAnimationFrame(resolve);
      });
    }
  }

  moved() {
    const { active, position } = this.combined;
    if (active === null) return;
    this.position = position;
    this.sources.add(active);
    const percent = Math.round(100 * position);
    this.slider.setAttribute("aria-valuenow", percent);
    this.slider.setAttribute("aria-valuetext", `${percent} percent${this.nearby(position)}`);
    if (this.touched) return;
    this.touched = true;
    this.ontouched();
  }

  /** Return the text of an event near a position, in visual conditions. */
  nearby(position) {
    const near = this.view.view?.events.find((event) => Math.abs(event.position - position) < STEP / 2);
    return near ? `, ${this.kinds[near.kind].name}` : "";
  }

  show(cursor) {
    const { x } = boxOf(this.slider.clientWidth, this.slider.clientHeight);
    this.finger.hidden = !this.touched;
    this.finger.classList.toggle("holding", this.combined.active !== null);
    this.finger.style.transform = `translateX(${x(this.position).toFixed(1)}px)`;
    this.view.at(cursor);
  }

  // --- inputs -----------------------------------------------------------------------------------

  listen() {
    const isAllowed = (input) => this.presentation !== null && [input, "any"].includes(this.input);
    // forwards to the input of the current presentation
    const touch = {
      moveTo: (source, place, time) => isAllowed("touch") && this.combined.moveTo(source, place, time),
      release: (source, time) => isAllowed("touch") && this.combined.release(source, time),
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
    const to = (place) => this.combined.moveTo("keys", place);
    const by = (step) => ({ shiftKey }) => to(this.combined.position + step * (shiftKey ? 10 : 1));
    const keys = {
      ArrowRight: by(STEP), ArrowUp: by(STEP), ArrowLeft: by(-STEP), ArrowDown: by(-STEP),
      PageUp: by(PAGE), PageDown: by(-PAGE),
      Home: () => to(0), End: () => to(1),
      " ": ({ repeat }) => repeat || this.combined.tap("keys", this.combined.position),
      Escape: () => this.combined.release("keys"),
    };
    this.slider.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.altKey || event.metaKey || !Object.hasOwn(keys, event.key)) return;
      event.preventDefault();
      if (this.presentation !== null) keys[event.key](event);
    });
    this.slider.addEventListener("blur", () => this.combined.release("keys"));
  }

  async toggleTwist() {
    const { twist } = this;
    twist.onsilent = (line) => {
      twist.end();
      this.toggle?.setAttribute("aria-pressed", "false");
      this.onfault(line);
    };
    try {
      if (twist.on) twist.end();
      else await twist.begin();
    } catch (error) {
      this.onfault(error.message);
    }
    this.toggle?.setAttribute("aria-pressed", String(twist.on));
  }
}
