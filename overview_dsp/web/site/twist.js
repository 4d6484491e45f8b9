// Twist of the wrist: the phone's roll about its long axis, face up to face down. Half a turn to either
// side is the whole timeline, so that both hands can twist.

import { MOTION_DENIED, NEEDS_HTTPS, NO_MOTION, NO_SENSOR } from "./page_words.js";

const MIN_GRAVITY = 0.25; // a phone held upright has no defined roll
const SILENT_MS = 1500; // sensors report about 60 times per second
const RAD_PER_DEGREE = Math.PI / 180;

/** @import { CombinedInput } from "./combined_input.js" */

/**
 * Return the roll in rad, -pi to pi, 0 face up; NaN for an upright phone.
 * @param {number} beta
 * @param {number} gamma
 */
export function rollOf(beta, gamma) {
  // direction of up along the phone's x and z (W3C DeviceOrientation: Z-X'-Y'')
  const x = -Math.cos(beta * RAD_PER_DEGREE) * Math.sin(gamma * RAD_PER_DEGREE);
  const z = Math.cos(beta * RAD_PER_DEGREE) * Math.cos(gamma * RAD_PER_DEGREE);
  return Math.hypot(x, z) < MIN_GRAVITY ? NaN : Math.atan2(-x, z);
}

/**
 * Return the position (0 to 1) of a roll; `start` is the roll at the timeline's start.
 * @param {number} roll
 * @param {number} start
 */
export function positionOfRoll(roll, start) {
  const turned = Math.abs(roll - start) % (2 * Math.PI);
  return Math.min(turned, 2 * Math.PI - turned) / Math.PI;
}

export class Twist {
  /** @param {Pick<CombinedInput, "moveTo" | "release">} input */
  constructor(input, start = 0) {
    this.input = input;
    this.start = start;
    this.roll = NaN;
    this.on = false;
    this.hasReading = false; // whether the sensor has reported
    /** Called with a message if the device has no sensor. */
    this.onsilent = /** @type {(line: string) => void} */ (() => {});
    this.onOrientation = (/** @type {DeviceOrientationEvent} */ event) => this.turn(event);
    /** @type {WakeLockSentinel | null} */
    this.lock = null; // wake lock: a page behind a locked screen gets no motion
    document.addEventListener("visibilitychange", () => this.keepAwake());
  }

  async keepAwake() {
    if (!this.on || document.hidden) return;
    try {
      this.lock = await navigator.wakeLock?.request("screen");
    } catch {
      this.lock = null; // rejected: low battery
    }
    if (!this.on) this.lock?.release();
  }

  /** Request permission and start; throw an Error if motion isn't available. */
  async begin() {
    if (!("DeviceOrientationEvent" in window)) throw new Error(NO_SENSOR);
    if (!window.isSecureContext) throw new Error(NEEDS_HTTPS);
    const ask = /** @type {any} */ (window.DeviceOrientationEvent).requestPermission;
    if (ask && (await ask.call(window.DeviceOrientationEvent)) !== "granted") {
      throw new Error(MOTION_DENIED);
    }
    this.on = true;
    this.hasReading = false;
    window.addEventListener("deviceorientation", this.onOrientation);
    this.keepAwake();
    clearTimeout(this.silent);
    this.silent = setTimeout(() => {
      if (this.on && !this.hasReading) this.onsilent(NO_MOTION);
    }, SILENT_MS);
  }

  end() {
    this.on = false;
    this.lock?.release();
    window.removeEventListener("deviceorientation", this.onOrientation);
    this.input.release("twist");
  }

  /** @param {DeviceOrientationEvent} event */
  turn({ beta, gamma, timeStamp }) {
    if (beta === null || gamma === null) return;
    this.hasReading = true;
    const roll = rollOf(beta, gamma);
    if (Number.isNaN(roll)) return;
    this.roll = roll;
    this.input.moveTo("twist", positionOfRoll(roll, this.start), timeStamp);
  }

  /** Use the current roll as the start and return it, rad. */
  calibrate() {
    if (!Number.isNaN(this.roll)) this.start = this.roll;
    return this.start;
  }
}
