// A phone's own motor in place of a tactor: its only knob is when it is on, so strength is the part
// of a short time for which it is.

const EVERY_MS = 60;
const PERIOD_MS = 20; // a motor needs some 10 ms to move at all
const LEAST_MS = 5;
const AHEAD = 5; // periods, so that a late call leaves no hole

/** On and off times (ms) for a level from 0 to 1; empty when it is too little to move anything. */
export function patternOf(level) {
  const on = Math.round(PERIOD_MS * Math.min(Math.max(level, 0), 1));
  if (on < LEAST_MS) return [];
  if (on === PERIOD_MS) return [PERIOD_MS * AHEAD];
  return Array.from({ length: 2 * AHEAD }, (_, i) => (i % 2 === 0 ? on : PERIOD_MS - on));
}

export class Motor {
  constructor(vibrate = (pattern) => navigator.vibrate?.(pattern)) {
    this.vibrate = vibrate;
    this.moving = false;
    this.last = -Infinity;
  }

  /** Every frame: the envelope (0 to 1) that the tactor has. */
  feel(level, now) {
    if (now - this.last < EVERY_MS) return;
    const pattern = patternOf(level);
    if (pattern.length === 0) {
      this.rest();
      return;
    }
    this.vibrate(pattern);
    this.moving = true;
    this.last = now;
  }

  rest() {
    if (this.moving) this.vibrate(0);
    this.moving = false;
  }
}
