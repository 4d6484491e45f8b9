// Every frame: asks the sound how the disk is and has it drawn; stops when nothing moves.

const QUIET_FRAMES = 40; // after which an unheld disk at rest is looked at no more

/** @import { SoundFace, Told } from "../types" */

export class Frames {
  /**
   * `draw()` is called every frame, `take(told)` with what the sound told.
   * @param {SoundFace} sound
   * @param {() => void} draw
   * @param {(told: Told) => void} take
   */
  constructor(sound, draw, take) {
    this.sound = sound;
    this.draw = draw;
    this.take = take;
    this.quiet = 0;
    this.running = false;
    this.looking = false;
  }

  wake() {
    this.quiet = 0;
    if (this.running) return;
    this.running = true;
    requestAnimationFrame(() => this.frame());
  }

  /**
   * Say of each look whether the disk rests.
   * @param {boolean} rests
   */
  rests(rests) {
    this.quiet = rests ? this.quiet + 1 : 0;
  }

  frame() {
    if (!this.sound.running) this.quiet += 1;
    this.draw();
    this.look();
    if (this.quiet > QUIET_FRAMES || document.hidden) this.running = false;
    else requestAnimationFrame(() => this.frame());
  }

  /** Ask how the disk is, for the next frame. */
  async look() {
    if (!this.sound.running || this.looking) return;
    this.looking = true;
    this.take(await this.sound.look());
    this.looking = false;
  }
}
