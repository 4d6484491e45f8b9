// The last seconds of torque, a value a frame, and where something was struck.

export const LENGTH = 300; // frames

export class Trace {
  /** `full` N m reach the edge. */
  constructor(full) {
    this.full = full;
    this.height = new Float32Array(LENGTH);
    this.struck = new Uint8Array(LENGTH);
    this.at = 0;
  }

  /** Torque (N m) now, and the strikes since the last frame, whose torque may be over by now. */
  push(torque, struck) {
    let most = torque;
    for (const one of struck) {
      if (Math.abs(one.torque) > Math.abs(most)) most = one.torque;
    }
    // cube root: a surface and its goals in one view
    this.height[this.at] = Math.max(-1, Math.min(1, Math.cbrt(most / this.full)));
    this.struck[this.at] = struck.length > 0 ? 1 : 0;
    this.at = (this.at + 1) % LENGTH;
  }

  /** Drawn the newest at the right. */
  draw(c, box, colours) {
    const step = (box.right - box.left) / (LENGTH - 1);
    c.beginPath();
    for (let i = 0; i < LENGTH; i += 1) {
      const height = this.height[(this.at + i) % LENGTH];
      c.lineTo(box.left + i * step, box.y - height * box.half);
    }
    c.strokeStyle = colours.trace;
    c.lineWidth = 1.5;
    c.stroke();
    c.beginPath();
    for (let i = 0; i < LENGTH; i += 1) {
      if (this.struck[(this.at + i) % LENGTH]) {
        const x = box.left + i * step;
        c.moveTo(x, box.y + box.half);
        c.lineTo(x, box.y + box.half + 5);
      }
    }
    c.strokeStyle = colours.hand;
    c.lineWidth = 2;
    c.stroke();
  }
}
