// A hand's moves as control events: the first of a touch is a step at once, the others are drawn
// out in small steps between the moments they were seen at. Pointers come 60 times a second, and
// so coarse a staircase would be felt as one.

const EVERY_S = 0.002;

/** @import { Clock } from "../types" */
const LONGEST_S = 0.025; // after a rest, a move is as quick as this

export class Strokes {
  /**
   * `send(place, touching, sample)`; `clock`: a SampleClock.
   * @param {Clock} clock
   * @param {(place: number, touching: boolean, sample: number) => void} send
   */
  constructor(clock, send) {
    this.clock = clock;
    this.send = send;
    this.last = -1;
    this.place = 0;
    this.touching = false;
  }

  /** @param {number} place */
  touch(place) {
    this.touching = true;
    this.place = place;
    this.last = -1;
    this.send(place, true, -1);
  }

  /**
   * @param {number} place
   * @param {number} time
   */
  move(place, time) {
    const { rate } = this.clock;
    let sample = this.clock.sampleAt(time);
    if (sample < 0) {
      this.place = place;
      this.send(place, true, -1);
      return;
    }
    // what comes late begins now: an event whose sample has passed would be a corner
    const now = this.clock.rendering(performance.now());
    const from = Math.max(this.last, now, sample - Math.round(LONGEST_S * rate));
    sample = Math.max(sample, from + 1);
    const steps = Math.ceil((sample - from) / (EVERY_S * rate));
    for (let i = 1; i <= steps; i += 1) {
      const part = i / steps;
      const at = Math.round(from + (sample - from) * part);
      this.send(this.place + (place - this.place) * part, true, at);
    }
    this.last = sample;
    this.place = place;
  }

  /** @param {number} time */
  release(time) {
    if (!this.touching) return;
    this.touching = false;
    const sample = this.clock.sampleAt(time);
    this.send(this.place, false, sample < 0 ? -1 : Math.max(sample, this.last + 1));
  }
}
