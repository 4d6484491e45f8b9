// When, in the kernel's samples, something happened that the page's clock stamped.
//
// The audio thread is asked for its sample count again and again; its answers come in bursts, so
// their mean is taken. A moment is a little ahead of its sample, so that a move can be drawn out
// between the two events it was seen at: `LEAD_S` is the price, and only moves pay it.

// a frame, since pointers are told once a frame, and one more less what the first one left
export const LEAD_S = 0.03;
const JUMP_S = 0.1; // a suspended output: begin again
const WEIGHT = 0.05;

export class SampleClock {
  /** @param {number} rate */
  constructor(rate) {
    this.rate = rate;
    this.offset = NaN; // samples
  }

  /**
   * The kernel had rendered `samples` at `now` (ms of performance.now).
   * @param {number} samples
   * @param {number} now
   */
  heard(samples, now) {
    const offset = samples - (now / 1e3) * this.rate;
    const error = offset - this.offset;
    if (!(Math.abs(error) < JUMP_S * this.rate)) this.offset = offset;
    else this.offset += WEIGHT * error;
  }

  /**
   * The sample at which what happened at `time` (ms) shall act; -1, at once, while unknown.
   * @param {number} time
   */
  sampleAt(time) {
    if (Number.isNaN(this.offset)) return -1;
    return Math.max(0, Math.round(this.offset + (time / 1e3 + LEAD_S) * this.rate));
  }

  /**
   * The sample that is rendered at `time`.
   * @param {number} time
   */
  rendering(time) {
    return Math.round(this.offset + (time / 1e3) * this.rate);
  }
}
