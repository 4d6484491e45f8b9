// One input made of several sources: touch, twist, keys and Play. The newest touch is active.
//
// The kernel receives one continuous input, so a change of source is neither a tap nor a jump (soft
// takeover). The new source continues from the old position. Its offset shrinks as it moves.

const CATCH_UP_SHARE = 0.5; // share of a movement by which the offset shrinks

/** @import { Source } from "../types" */
/** @import { Strokes } from "./strokes.js" */

export class CombinedInput {
  /**
   * `strokes` receives the movement; `onchange` is called after each change.
   * @param {Strokes} strokes
   */
  constructor(strokes) {
    this.strokes = strokes;
    /** @type {Source[]} */
    this.touching = []; // sources that touch, newest first
    /** @type {Record<Source, number>} */
    this.positions = { touch: 0, twist: 0, keys: 0, play: 0 }; // last position of each source, 0 to 1
    this.offset = 0; // from the active source to the input's position
    this.position = 0;
    this.onchange = () => {};
  }

  get active() {
    return this.touching[0] ?? null;
  }

  /**
   * Touch at `position` (0 to 1), or move there.
   * @param {Source} source
   * @param {number} position
   */
  moveTo(source, position, time = performance.now()) {
    const target = Math.min(Math.max(position, 0), 1);
    const before = this.positions[source];
    this.positions[source] = target;
    if (this.active === null) {
      this.touching = [source];
      this.offset = 0;
      this.position = target;
      this.strokes.touch(target);
    } else if (!this.touching.includes(source)) {
      this.touching.unshift(source);
      this.offset = this.position - target;
      return;
    } else if (this.active === source) {
      const closing = Math.min(Math.abs(this.offset), CATCH_UP_SHARE * Math.abs(target - before));
      this.offset -= Math.sign(this.offset) * closing;
      this.position = Math.min(Math.max(target + this.offset, 0), 1);
      this.strokes.move(this.position, time);
    } else {
      return;
    }
    this.onchange();
  }

  /**
   * Release and touch again: a small movement alone would stay within the backlash.
   * @param {Source} source
   * @param {number} position
   */
  touchAgain(source, position) {
    if (this.active !== source) {
      this.moveTo(source, position);
      return;
    }
    this.position = this.positions[source] = Math.min(Math.max(position, 0), 1);
    this.offset = 0;
    this.strokes.release(performance.now());
    this.strokes.touch(this.position);
    this.onchange();
  }

  /**
   * Move the position after a change of the window: of keys, or of a released input.
   * @param {number} position
   */
  stayAt(position) {
    const target = Math.min(Math.max(position, 0), 1);
    if (Math.abs(target - this.position) < 1e-9) return;
    if (this.active === "keys") this.touchAgain("keys", target);
    else if (this.active === null) this.position = target;
  }

  /**
   * Release a source; another source that touches becomes active.
   * @param {Source} source
   */
  release(source, time = performance.now()) {
    if (!this.touching.includes(source)) return;
    const wasActive = this.active === source;
    this.touching = this.touching.filter((one) => one !== source);
    if (!wasActive) return;
    if (this.active !== null) this.offset = this.position - this.positions[this.active];
    else this.strokes.release(time);
    this.onchange();
  }

  /**
   * Touch at `position` and release at once, unless another source touches.
   * @param {Source} source
   * @param {number} position
   */
  tap(source, position) {
    if (this.active === source) this.release(source);
    this.moveTo(source, position);
    this.release(source);
  }

  /** Release every source. */
  releaseAll() {
    for (const source of [...this.touching].reverse()) this.release(source);
  }
}
