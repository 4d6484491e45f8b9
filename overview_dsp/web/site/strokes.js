// Movements as control events. A touch is one step; later movements are interpolated between pointer
// events. Browsers report pointers 60 times per second, and steps of that size would be felt.

const STEP_S = 0.002;

/** @import { Clock } from "../types" */
const LONGEST_S = 0.025; // maximum duration of an interpolated movement

export class Strokes {
  /**
   * `send(position, touching, sample)` receives each event; sample -1: as soon as possible.
   * @param {Clock} clock
   * @param {(position: number, touching: boolean, sample: number) => void} send
   */
  constructor(clock, send) {
    this.clock = clock;
    this.send = send;
    this.lastSample = -1;
    this.position = 0;
    this.touching = false;
  }

  /** @param {number} position */
  touch(position) {
    this.touching = true;
    this.position = position;
    this.lastSample = -1;
    this.send(position, true, -1);
  }

  /**
   * @param {number} position
   * @param {number} time
   */
  move(position, time) {
    const { rate } = this.clock;
    let sample = this.clock.sampleAt(time);
    if (sample < 0) {
      this.position = position;
      this.send(position, true, -1);
      return;
    }
    // a late movement starts now: an event in the past would be a jump
    const now = this.clock.rendering(performance.now());
    const from = Math.max(this.lastSample, now, sample - Math.round(LONGEST_S * rate));
    sample = Math.max(sample, from + 1);
    const steps = Math.ceil((sample - from) / (STEP_S * rate));
    for (let i = 1; i <= steps; i += 1) {
      const share = i / steps;
      const at = Math.round(from + (sample - from) * share);
      this.send(this.position + (position - this.position) * share, true, at);
    }
    this.lastSample = sample;
    this.position = position;
  }

  /** @param {number} time */
  release(time) {
    if (!this.touching) return;
    this.touching = false;
    const sample = this.clock.sampleAt(time);
    this.send(this.position, false, sample < 0 ? -1 : Math.max(sample, this.lastSample + 1));
  }
}
