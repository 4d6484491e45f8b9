// Vibration by a phone's own motor, which can only be on or off, and needs about 10 ms to start. Each
// event kind has a pattern; the surface between events is a row of short pulses.
//
// Patterns are triggered by strikes: the envelope of a strike may have decayed between two frames. A
// game pad supports strength and gets the peak since the last frame.

const EVERY_MS = 50; // between two pulses of the surface
const FLOOR = 0.02; // of full scale: too weak to feel on a tactor
const LEAST_MS = 8;
const MOST_MS = 22; // shorter than the first pulse of every event but a tick
const LONG_MS = 50; // longer than a card's pulse, shorter than a goal's
const GAP_MS = 15; // separates two patterns
const LATE_MS = 25; // maximum wait of a minor event for a major one
const PAD_MS = 60;

/**
 * Return the length (ms) of a surface pulse for a level from 0 to 1; 0 if it can't be felt.
 * @param {number} level
 */
export function pulseOf(level) {
  if (level < FLOOR) return 0;
  // square root, as amplitude is perceived: a weak hum stays noticeable
  return Math.round(LEAST_MS + (MOST_MS - LEAST_MS) * Math.sqrt(Math.min(level, 1)));
}

/** @param {number[]} pattern */
const lengthOf = (pattern) => pattern.reduce((sum, one) => sum + one, 0);

export class Motor {
  /** `vibrate(pattern)` takes on and off times (ms); `pads()` returns the game pads. */
  constructor(
    vibrate = (/** @type {any} */ pattern) => navigator.vibrate?.(pattern),
    pads = () => navigator.getGamepads?.() ?? [],
  ) {
    this.vibrate = vibrate;
    this.pads = pads;
    /** @type {number[] | null} */
    this.pattern = null; // active pattern of an event or the surface
    this.weight = 0; // first pulse of the active event, ms; 0 for the surface
    this.began = -Infinity;
    this.surfaceFrom = -Infinity; // time of the next surface pulse
    this.padsBusyUntil = -Infinity; // time of the next command to game pads
    this.isRunning = false;
  }

  /**
   * Update once per frame with the patterns of new strikes and the tactor's peak (0 to 1).
   * @param {number[][]} patterns
   * @param {number} level
   * @param {number} now
   */
  play(patterns, level, now) {
    const heaviest = patterns.reduce((/** @type {number[] | null} */ most, pattern) => (pattern[0] > (most?.[0] ?? 0) ? pattern : most), null);
    if (heaviest !== null) this.playEvent(heaviest, now);
    else if (now >= this.surfaceFrom) this.playSurface(level, now);
    this.playPads(heaviest === null ? level : Math.max(level, 0.6), heaviest !== null, now);
  }

  /**
   * @param {number[]} pattern
   * @param {number} now
   */
  playEvent(pattern, now) {
    const left = this.pattern === null ? 0 : this.began + lengthOf(this.pattern) - now;
    /** @type {number[]} */
    let ending = []; // rest of the active pattern
    if (left > 0) {
      const isLighter = pattern[0] < this.weight;
      if (isLighter && left + GAP_MS > LATE_MS) return; // the major event hides it
      // a goal stays recognisable if another goal follows
      const remaining = this.weight >= LONG_MS ? this.began + LONG_MS - now : 1;
      const more = Math.max(1, Math.ceil(isLighter ? left : remaining));
      // a goal may extend a surface pulse; a card would then resemble a goal
      if (this.weight > 0 || pattern[0] < LONG_MS) ending = [more, GAP_MS];
    }
    this.start([...ending, ...pattern]);
    this.pattern = pattern;
    this.weight = pattern[0];
    this.began = now + lengthOf(ending);
    this.surfaceFrom = this.began + lengthOf(pattern) + 2 * GAP_MS;
  }

  /**
   * @param {number} level
   * @param {number} now
   */
  playSurface(level, now) {
    const pulse = pulseOf(level);
    this.pattern = [pulse];
    this.weight = 0;
    this.began = now;
    if (pulse === 0) {
      this.stop();
      return;
    }
    this.start(this.pattern);
    this.surfaceFrom = now + EVERY_MS;
  }

  /** @param {number[]} pattern */
  start(pattern) {
    this.vibrate(pattern);
    this.isRunning = true;
  }

  /**
   * Game pads use the strong motor for events and the weak one for the surface.
   * @param {number} level
   * @param {boolean} isEvent
   * @param {number} now
   */
  playPads(level, isEvent, now) {
    if (now < this.padsBusyUntil && !isEvent) return;
    for (const pad of this.pads()) {
      if (!pad?.vibrationActuator?.playEffect) continue;
      pad.vibrationActuator.playEffect("dual-rumble", {
        duration: 2 * PAD_MS,
        strongMagnitude: isEvent ? Math.min(level, 1) : 0,
        weakMagnitude: Math.min(level, 1),
      });
      this.padsBusyUntil = now + PAD_MS;
    }
  }

  stop() {
    if (this.isRunning) this.vibrate(0);
    this.isRunning = false;
    this.pattern = null; // the next event is not preceded by its rest
    this.weight = 0;
  }
}
