// Conversion from the page's clock to the kernel's samples.
//
// The audio thread reports its sample count once per frame, at irregular times, so the offset is
// averaged. Movements are delayed by `LEAD_S`, which leaves time to interpolate between two pointer
// events. Touches and releases aren't delayed.

// browsers report pointers once per frame; `LEAD_S` covers two frames
export const LEAD_S = 0.03;
const JUMP_S = 0.1; // after a suspended output the offset is measured again
const WEIGHT = 0.05;

export class SampleClock {
  /** @param {number} rate */
  constructor(rate) {
    this.rate = rate;
    this.offset = NaN; // samples
  }

  /**
   * Note that the kernel had rendered `samples` at `now` (ms of performance.now).
   * @param {number} samples
   * @param {number} now
   */
  addReading(samples, now) {
    const offset = samples - (now / 1e3) * this.rate;
    const error = offset - this.offset;
    if (!(Math.abs(error) < JUMP_S * this.rate)) this.offset = offset;
    else this.offset += WEIGHT * error;
  }

  /**
   * Return the sample for an event at `time` (ms); -1 (at once) before the first measurement.
   * @param {number} time
   */
  sampleAt(time) {
    if (Number.isNaN(this.offset)) return -1;
    return Math.max(0, Math.round(this.offset + (time / 1e3 + LEAD_S) * this.rate));
  }

  /**
   * Return the sample that is rendered at `time`.
   * @param {number} time
   */
  rendering(time) {
    return Math.round(this.offset + (time / 1e3) * this.rate);
  }
}
