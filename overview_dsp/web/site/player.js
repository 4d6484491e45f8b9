// Playback of a sweep or a tap, as a source that any other source may replace.

const AGAIN_MS = 1500; // between two repeats
/** @type {Sweep} */
export const SWEEP = { name: "sweep", seconds: 10, from: 0, to: 1 };

/** @import { Gesture, Sweep } from "../types" */
/** @import { CombinedInput } from "./combined_input.js" */

/**
 * Return the gesture of a text such as "sweep:SECONDS[:FROM:TO]" or "tap:POSITION"; null if invalid.
 * @param {string | null} text
 * @returns {Gesture | null}
 */
export function gestureOf(text) {
  const [name, ...fields] = (text ?? "").split(":");
  const numbers = fields.map(Number);
  if (numbers.some((one) => !Number.isFinite(one))) return null;
  const inside = (/** @type {number} */ position) => position >= 0 && position <= 1;
  if (name === "sweep") {
    const [seconds = SWEEP.seconds, from = 0, to = 1] = numbers;
    const isValid = seconds >= 0.2 && seconds <= 600 && inside(from) && inside(to);
    return isValid ? { name, seconds, from, to } : null;
  }
  const [position = NaN] = numbers;
  return name === "tap" && inside(position) ? { name, position } : null;
}

/** Return the text of a gesture. @param {Gesture} gesture */
export const gestureText = (gesture) => {
  if (gesture.name === "tap") return `tap:${gesture.position}`;
  const { seconds, from, to } = gesture;
  return from === 0 && to === 1 ? `sweep:${seconds}` : `sweep:${seconds}:${from}:${to}`;
};

export class Player {
  /**
   * `onchange(sweep, isEnd)` is called with a sweep at its start, and with null at pause and end.
   * @param {CombinedInput} input
   * @param {(sweep: Sweep | null, isEnd: boolean) => void} onchange
   */
  constructor(input, onchange) {
    this.input = input;
    this.onchange = onchange;
    this.loop = false;
    /** @type {Gesture | null} */
    this.gesture = null;
    this.done = 0; // s of the gesture that were played
    this.playing = this.started = false;
    this.last = 0; // time of the last step, ms
    this.timer = 0; // of the next repeat
  }

  /**
   * Play a gesture from its start, or from where the same gesture was paused.
   * @param {Gesture} gesture
   */
  play(gesture) {
    const same = this.gesture !== null && gestureText(gesture) === gestureText(this.gesture);
    if (!same) this.done = 0;
    this.gesture = gesture;
    this.input.releaseAll(); // keys that hold the disk would take over at their position
    if (gesture.name === "tap") {
      this.input.tap("play", gesture.position);
      return;
    }
    this.playing = true;
    this.started = false;
    this.last = performance.now();
    this.onchange(gesture, false);
    requestAnimationFrame(() => this.step());
  }

  pause(isEnd = false) {
    clearTimeout(this.timer);
    if (!this.playing) return;
    this.playing = false;
    this.input.release("play");
    this.onchange(null, isEnd);
  }

  step() {
    const { input, gesture } = this;
    if (!this.playing || gesture?.name !== "sweep") return;
    if (this.started && input.active !== "play") {
      this.pause(); // another source took over, or the disk was released
      return;
    }
    const now = performance.now();
    this.done += this.started ? (now - this.last) / 1e3 : 0;
    this.last = now;
    this.started = true;
    const share = Math.min(this.done / gesture.seconds, 1);
    input.moveTo("play", gesture.from + (gesture.to - gesture.from) * share, now);
    if (share === 1) this.end();
    else requestAnimationFrame(() => this.step());
  }

  end() {
    this.pause(true);
    this.done = 0;
    if (!this.loop || this.input.active !== null) return;
    this.timer = setTimeout(() => this.gesture && this.play(this.gesture), AGAIN_MS);
  }
}
