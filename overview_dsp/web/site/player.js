// Plays by itself: a sweep or a tap, as a hand of its own that any other may take over.

const AGAIN_MS = 1500; // between two rounds

/** @import { Gesture } from "../types" */
/** @import { Hand } from "./hand.js" */

/**
 * A gesture from words as the command line's: "sweep:SECONDS[:FROM:TO]", "tap:PLACE"; or null.
 * @param {string | null} words
 * @returns {Gesture | null}
 */
export function gestureOf(words) {
  const [name, ...given] = (words ?? "").split(":");
  const numbers = given.map(Number);
  if (numbers.some((one) => !Number.isFinite(one))) return null;
  const inside = (/** @type {number} */ place) => place >= 0 && place <= 1;
  if (name === "sweep") {
    const [seconds = 10, from = 0, to = 1] = numbers;
    const known = seconds >= 0.2 && seconds <= 600 && inside(from) && inside(to);
    return known ? { name, seconds, from, to } : null;
  }
  const [place = NaN] = numbers;
  return name === "tap" && inside(place) ? { name, place } : null;
}

/** The words of a gesture. @param {any} gesture */
export const wordsOf = ({ name, seconds, from, to, place }) => {
  if (name === "tap") return `tap:${place}`;
  return from === 0 && to === 1 ? `sweep:${seconds}` : `sweep:${seconds}:${from}:${to}`;
};

export class Player {
  /**
   * `onchange(playing)` is told when it begins and ends.
   * @param {Hand} hand
   * @param {(playing: boolean) => void} onchange
   */
  constructor(hand, onchange) {
    this.hand = hand;
    this.onchange = onchange;
    this.loop = false;
    /** @type {Gesture | null} */
    this.gesture = null;
    this.done = 0; // s of it that were played
    this.playing = false;
    this.waits = 0; // timer of the next round
  }

  /**
   * From its start, or (the same gesture) from where it was paused.
   * @param {Gesture} gesture
   */
  play(gesture) {
    const same = this.gesture !== null && wordsOf(gesture) === wordsOf(this.gesture);
    if (!same) this.done = 0;
    this.gesture = gesture;
    this.hand.releaseAll(); // what keys hold would be taken over where it is
    if (gesture.name === "tap") {
      this.hand.tap("play", gesture.place);
      return;
    }
    this.playing = true;
    this.begun = false;
    this.last = performance.now();
    this.onchange(true);
    requestAnimationFrame(() => this.step());
  }

  pause() {
    clearTimeout(this.waits);
    if (!this.playing) return;
    this.playing = false;
    this.hand.release("play");
    this.onchange(false);
  }

  step() {
    if (!this.playing) return;
    const { hand, gesture } = this;
    if (this.begun && hand.holder !== "play") {
      this.pause(); // another hand has taken it, or it was let go
      return;
    }
    const now = performance.now();
    this.done += this.begun ? (now - this.last) / 1e3 : 0;
    this.last = now;
    this.begun = true;
    const part = Math.min(this.done / gesture.seconds, 1);
    hand.hold("play", gesture.from + (gesture.to - gesture.from) * part, now);
    if (part === 1) this.end();
    else requestAnimationFrame(() => this.step());
  }

  end() {
    this.pause();
    this.done = 0;
    if (!this.loop || this.hand.holder !== null) return;
    this.waits = setTimeout(() => this.play(this.gesture), AGAIN_MS);
  }
}
