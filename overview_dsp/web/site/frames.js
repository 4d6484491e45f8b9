// The frame loop: reads the disk's state and draws it; stops when nothing moves.

const QUIET_FRAMES = 40; // frames at rest after which the loop stops

/** @import { AudioBackend, DiskState } from "../types" */

export class Frames {
  /**
   * `draw()` is called every frame, `onState(state)` with each state of the disk.
   * @param {AudioBackend} sound
   * @param {() => void} draw
   * @param {(state: DiskState) => void} onState
   */
  constructor(sound, draw, onState) {
    this.sound = sound;
    this.draw = draw;
    this.onState = onState;
    this.quietFrames = 0;
    this.running = false;
    this.isReading = false;
  }

  wake() {
    this.quietFrames = 0;
    if (this.running) {
      this.read(); // in one message with the movement
      return;
    }
    this.running = true;
    requestAnimationFrame(() => this.frame());
  }

  /**
   * Note whether the disk is at rest.
   * @param {boolean} isAtRest
   */
  setAtRest(isAtRest) {
    this.quietFrames = isAtRest ? this.quietFrames + 1 : 0;
  }

  frame() {
    if (!this.sound.running) this.quietFrames += 1;
    this.draw();
    this.read();
    if (this.quietFrames > QUIET_FRAMES || document.hidden) this.running = false;
    else requestAnimationFrame(() => this.frame());
  }

  /** Request the state of the disk for the next frame. */
  async read() {
    if (!this.sound.running || this.isReading) return;
    this.isReading = true;
    const state = await this.sound.readState();
    if (state !== null) this.onState(state);
    this.isReading = false;
  }
}
