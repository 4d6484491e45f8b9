// A phone's own motor in place of a tactor. It only knows on and off, and takes some 10 ms to move
// at all: an event is a pulse code of its kind, what lies between events is a row of short pulses.
//
// Events are never too weak: a motor that looked at the envelope alone would miss the one that has
// rung off between two frames. Whatever has strength (a game pad) gets the peak since the last look.

const EVERY_MS = 50; // from one pulse of the surface to the next
const FLOOR = 0.02; // of full scale: what a finger on a tactor wouldn't feel either
const LEAST_MS = 8;
const MOST_MS = 22; // shorter than any event's first pulse but a tick
const LONG_MS = 50; // as pulses.py has them: a goal's is longer, a card's shorter
const GAP_MS = 15; // between two codes, so that they are two
const LATE_MS = 25; // a lesser event waits so long for a greater one's code to end
const PAD_MS = 60;

/**
 * How long (ms) a pulse of the surface is at a level from 0 to 1; 0 where nothing is felt.
 * @param {number} level
 */
export function pulseOf(level) {
  if (level < FLOOR) return 0;
  // as a tactor's amplitude is felt, so that an even hum isn't lost below a crowd
  return Math.round(LEAST_MS + (MOST_MS - LEAST_MS) * Math.sqrt(Math.min(level, 1)));
}

/** @param {number[]} pattern */
const lengthOf = (pattern) => pattern.reduce((sum, one) => sum + one, 0);

export class Motor {
  /** `vibrate(pattern)` of on and off times (ms), `pads()` the game pads. */
  constructor(
    vibrate = (/** @type {any} */ pattern) => navigator.vibrate?.(pattern),
    pads = () => navigator.getGamepads?.() ?? [],
  ) {
    this.vibrate = vibrate;
    this.pads = pads;
    /** @type {number[] | null} */
    this.code = null; // what is on: an event's, or a pulse of the surface
    this.weight = 0; // an event's first pulse, ms; 0 for the surface
    this.began = -Infinity;
    this.next = -Infinity; // when the surface may be felt again
    this.padded = -Infinity; // until when game pads were told
    this.moving = false;
  }

  /**
   * Every frame: the codes of what was struck since the last one, the tactor's peak (0 to 1).
   * @param {number[][]} codes
   * @param {number} level
   * @param {number} now
   */
  feel(codes, level, now) {
    const heaviest = codes.reduce((/** @type {number[] | null} */ most, code) => (code[0] > (most?.[0] ?? 0) ? code : most), null);
    if (heaviest !== null) this.strike(heaviest, now);
    else if (now >= this.next) this.hum(level, now);
    this.feelPads(heaviest === null ? level : Math.max(level, 0.6), heaviest !== null, now);
  }

  /**
   * @param {number[]} code
   * @param {number} now
   */
  strike(code, now) {
    const left = this.code === null ? 0 : this.began + lengthOf(this.code) - now;
    /** @type {number[]} */
    let first = []; // how what is on ends
    if (left > 0) {
      const waits = code[0] < this.weight;
      if (waits && left + GAP_MS > LATE_MS) return; // it is behind the greater one
      // a goal that the next one cuts short is still one
      const owed = this.weight >= LONG_MS ? this.began + LONG_MS - now : 1;
      const more = Math.max(1, Math.ceil(waits ? left : owed));
      // a goal over the surface's pulse is only longer; a card would seem to be one
      if (this.weight > 0 || code[0] < LONG_MS) first = [more, GAP_MS];
    }
    this.start([...first, ...code]);
    this.code = code;
    this.weight = code[0];
    this.began = now + lengthOf(first);
    this.next = this.began + lengthOf(code) + 2 * GAP_MS;
  }

  /**
   * @param {number} level
   * @param {number} now
   */
  hum(level, now) {
    const pulse = pulseOf(level);
    this.code = [pulse];
    this.weight = 0;
    this.began = now;
    if (pulse === 0) {
      this.rest();
      return;
    }
    this.start(this.code);
    this.next = now + EVERY_MS;
  }

  /** @param {number[]} pattern */
  start(pattern) {
    this.vibrate(pattern);
    this.moving = true;
  }

  /**
   * Game pads have strength: the heavy motor for events, the light one for the surface.
   * @param {number} level
   * @param {boolean} struck
   * @param {number} now
   */
  feelPads(level, struck, now) {
    if (now < this.padded && !struck) return;
    for (const pad of this.pads()) {
      if (!pad?.vibrationActuator?.playEffect) continue;
      pad.vibrationActuator.playEffect("dual-rumble", {
        duration: 2 * PAD_MS,
        strongMagnitude: struck ? Math.min(level, 1) : 0,
        weakMagnitude: Math.min(level, 1),
      });
      this.padded = now + PAD_MS;
    }
  }

  rest() {
    if (this.moving) this.vibrate(0);
    this.moving = false;
  }
}
