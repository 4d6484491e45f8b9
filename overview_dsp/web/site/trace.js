// The last seconds of torque, one value per frame, with marks at the strikes.

import { contextOf } from "./dom.js";

export const LENGTH = 240; // frames
const MARK = 5; // px of a strike's mark

/** @import { Colours, TraceBox } from "../types" */
/** @import { Strike } from "../kernel_node" */

export class Trace {
  /**
   * `full` is the torque (N m) at full height.
   * @param {HTMLCanvasElement} canvas
   * @param {number} full
   */
  constructor(canvas, full) {
    this.canvas = canvas;
    this.c = contextOf(canvas);
    this.full = full;
    this.height = new Float32Array(LENGTH);
    this.hasStrike = new Uint8Array(LENGTH);
    this.at = 0; // index of the next value
    /** @type {TraceBox | null} */
    this.box = null;
    this.scale = 1;
    this.fresh = true; // whether there is anything new to draw
    this.turn = false;
  }

  /**
   * Lay out the trace in a box of the picture; null hides it.
   * @param {TraceBox | null} box
   * @param {number} scale
   */
  layOut(box, scale) {
    const { canvas } = this;
    this.box = box;
    this.fresh = true;
    canvas.hidden = box === null;
    if (box === null) return;
    this.scale = Math.min(scale, 2); // more pixels don't make a moving line sharper
    const width = box.right - box.left;
    const height = 2 * box.half + 8;
    canvas.style.left = `${box.left}px`;
    canvas.style.top = `${box.y - box.half}px`;
    canvas.style.width = `${width}px`;
    canvas.style.height = `${height}px`;
    canvas.width = Math.round(width * this.scale);
    canvas.height = Math.round(height * this.scale);
  }

  /**
   * Add the torque (N m) and the strikes since the last frame, which may have ended.
   * @param {number} torque
   * @param {Strike[]} newStrikes
   */
  push(torque, newStrikes) {
    let most = torque;
    for (const one of newStrikes) {
      if (Math.abs(one.torque) > Math.abs(most)) most = one.torque;
    }
    // cube root: shows both the surface and goals
    this.height[this.at] = Math.max(-1, Math.min(1, Math.cbrt(most / this.full)));
    this.hasStrike[this.at] = newStrikes.length > 0 ? 1 : 0;
    this.at = (this.at + 1) % LENGTH;
    this.fresh = true;
  }

  /**
   * Draw the trace, newest at the right.
   * @param {Colours} colours
   */
  draw(colours) {
    const { c, box, canvas } = this;
    this.turn = !this.turn; // every second frame is enough to read a torque
    if (box === null || !this.fresh || this.turn) return;
    this.fresh = false;
    const { width, height } = canvas;
    const half = Math.round(box.half * this.scale);
    c.clearRect(0, 0, width, height);
    // bars on whole pixels need no smoothing
    const step = Math.ceil(width / LENGTH);
    const count = Math.floor(width / step);
    const first = this.at + LENGTH - count;
    c.fillStyle = colours.trace;
    for (let i = 0; i < count; i += 1) {
      const y = Math.round(half * (1 - this.height[(first + i) % LENGTH]));
      c.fillRect(i * step, Math.min(y, half - 1), step, Math.abs(half - y) || 1);
    }
    const mark = Math.round(MARK * this.scale);
    c.fillStyle = colours.accent;
    for (let i = 0; i < count; i += 1) {
      if (this.hasStrike[(first + i) % LENGTH]) c.fillRect(i * step, 2 * half, step, mark);
    }
  }
}
