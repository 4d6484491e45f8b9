// Curve drawn by the participant, with a pen or with handles.

const COLUMNS = 64; // values of an answer
export const HANDLES = 16;

export class Curve {
  constructor() {
    this.values = new Array(COLUMNS).fill(0);
    this.drawn = false;
    this.last = null; // last pen position and level
  }

  /** Start a pen stroke. */
  begin(position, level) {
    this.last = null;
    this.move(position, level);
  }

  /** Continue the stroke to a position (0 to 1), with linear interpolation. */
  move(position, level) {
    const from = this.last ?? { position, level };
    this.last = { position, level };
    this.drawn = true;
    const [a, b] = [columnOf(from.position), columnOf(position)];
    for (let i = Math.min(a, b); i <= Math.max(a, b); i += 1) {
      const part = a === b ? 1 : (i - a) / (b - a);
      this.values[i] = rounded(from.level + (level - from.level) * part);
    }
  }

  /** Set a handle; values between handles are interpolated linearly. */
  setHandle(handle, level) {
    this.drawn = true;
    const at = columnOfHandle(handle);
    this.values[at] = rounded(level);
    for (const next of [handle - 1, handle + 1]) {
      if (next < 0 || next >= HANDLES) continue;
      const end = columnOfHandle(next);
      const step = Math.sign(end - at);
      for (let i = at; i !== end; i += step) {
        this.values[i] = rounded(level + (this.values[end] - level) * ((i - at) / (end - at)));
      }
    }
  }

  handle(number) {
    return this.values[columnOfHandle(number)];
  }

  clear() {
    this.values.fill(0);
    this.drawn = false;
  }

  get response() {
    return this.drawn ? [...this.values] : null;
  }
}

const columnOf = (position) => Math.round(position * (COLUMNS - 1));
const columnOfHandle = (handle) => columnOf(handle / (HANDLES - 1));
const rounded = (level) => Math.round(Math.min(Math.max(level, 0), 1) * 1000) / 1000;
