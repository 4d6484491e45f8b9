// The last seconds of torque, a value a frame, and where something was struck.

export const LENGTH = 240; // frames

export class Trace {
  /** `full` N m reach the edge. */
  constructor(canvas, full) {
    this.canvas = canvas;
    this.c = canvas.getContext("2d");
    this.full = full;
    this.height = new Float32Array(LENGTH);
    this.struck = new Uint8Array(LENGTH);
    this.at = 0;
    this.box = null;
    this.fresh = true;
    this.turn = false;
  }

  /** Lay it out in a box of the picture, or (null) not at all. */
  place(box, scale) {
    const { canvas } = this;
    this.box = box;
    this.fresh = true;
    canvas.hidden = box === null;
    if (box === null) return;
    this.scale = Math.min(scale, 2); // a line that moves is as sharp
    const width = box.right - box.left;
    const height = 2 * box.half + 8;
    canvas.style.left = `${box.left}px`;
    canvas.style.top = `${box.y - box.half}px`;
    canvas.style.width = `${width}px`;
    canvas.style.height = `${height}px`;
    canvas.width = Math.round(width * this.scale);
    canvas.height = Math.round(height * this.scale);
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
    this.fresh = true;
  }

  /** Drawn the newest at the right. */
  draw(colours) {
    const { c, box, canvas } = this;
    this.turn = !this.turn; // every second frame: nobody reads a torque 60 times a second
    if (box === null || !this.fresh || this.turn) return;
    this.fresh = false;
    c.setTransform(1, 0, 0, 1, 0, 0);
    c.clearRect(0, 0, canvas.width, canvas.height);
    c.setTransform(this.scale, 0, 0, this.scale, 0, 0);
    const step = (box.right - box.left) / (LENGTH - 1);
    c.beginPath();
    for (let i = 0; i < LENGTH; i += 1) {
      c.lineTo(i * step, box.half * (1 - this.height[(this.at + i) % LENGTH]));
    }
    c.strokeStyle = colours.trace;
    c.lineWidth = 1.5;
    c.stroke();
    c.fillStyle = colours.hand;
    for (let i = 0; i < LENGTH; i += 1) {
      if (this.struck[(this.at + i) % LENGTH]) c.fillRect(i * step - 1, 2 * box.half, 2, 6);
    }
  }
}
