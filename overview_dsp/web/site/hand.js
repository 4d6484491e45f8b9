// One hand of several sources: touch, twist, keys. The last to hold has it, and gives it back.
//
// The kernel gets one source that never lets go in between, so a change of hands is neither a tap
// nor a jump (soft takeover): the one that takes over goes on from where the other was, and what
// lies between them is made up as it moves, always in the direction of its movement.

const MADE_UP = 0.5; // of a gap, for each movement as long as the gap

/** @import { Source } from "../types" */
/** @import { Strokes } from "./strokes.js" */

export class Hand {
  /**
   * `strokes`: what takes its movement; `onchange` is called after each.
   * @param {Strokes} strokes
   */
  constructor(strokes) {
    this.strokes = strokes;
    /** @type {Source[]} */
    this.held = []; // sources that hold, the last one first
    /** @type {Partial<Record<Source, number>>} */
    this.raw = {}; // where each is, 0 to 1
    this.gap = 0; // from where the holder is to where the hand is
    this.place = 0;
    this.onchange = () => {};
  }

  get holder() {
    return this.held[0] ?? null;
  }

  /**
   * A source holds at `place` (0 to 1), or moves there.
   * @param {Source} source
   * @param {number} place
   */
  hold(source, place, time = performance.now()) {
    const raw = Math.min(Math.max(place, 0), 1);
    const before = this.raw[source];
    this.raw[source] = raw;
    if (this.holder === null) {
      this.held = [source];
      this.gap = 0;
      this.place = raw;
      this.strokes.touch(raw);
    } else if (!this.held.includes(source)) {
      this.held.unshift(source);
      this.gap = this.place - raw;
      return;
    } else if (this.holder === source) {
      const made = Math.min(Math.abs(this.gap), MADE_UP * Math.abs(raw - before));
      this.gap -= Math.sign(this.gap) * made;
      this.place = Math.min(Math.max(raw + this.gap, 0), 1);
      this.strokes.move(this.place, time);
    } else {
      return;
    }
    this.onchange();
  }

  /**
   * A source touches anew, so that the disk arrives at `place`: a move is held back by the backlash.
   * @param {Source} source
   * @param {number} place
   */
  setDown(source, place) {
    if (this.holder !== source) {
      this.hold(source, place);
      return;
    }
    this.place = this.raw[source] = Math.min(Math.max(place, 0), 1);
    this.gap = 0;
    this.strokes.release(performance.now());
    this.strokes.touch(this.place);
    this.onchange();
  }

  /**
   * A source lets go: another that still holds goes on, or the disk, which arrives and recoils.
   * @param {Source} source
   */
  release(source, time = performance.now()) {
    if (!this.held.includes(source)) return;
    const had = this.holder === source;
    this.held = this.held.filter((one) => one !== source);
    if (!had) return;
    if (this.holder !== null) this.gap = this.place - this.raw[this.holder];
    else this.strokes.release(time);
    this.onchange();
  }

  /**
   * A step to `place` that is released at once (unless another hand holds): the disk goes there.
   * @param {Source} source
   * @param {number} place
   */
  tap(source, place) {
    if (this.holder === source) this.release(source);
    this.hold(source, place);
    this.release(source);
  }

  /** Nothing sticks: the page is left, the sound is lost. */
  releaseAll() {
    for (const source of [...this.held].reverse()) this.release(source);
  }
}
