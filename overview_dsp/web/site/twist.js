// A twist of the wrist: how far the phone is rolled about its long axis, face up to face down.
//
// Both hands turn outwards and inwards, so the side doesn't count: half a turn either way is the
// whole timeline.

const UPRIGHT = 0.25; // held on end, gravity says nothing about the roll
const SILENT_MS = 1500; // a sensor tells sixty times a second
const RAD = Math.PI / 180;

/** @import { Hand } from "./hand.js" */

/**
 * Roll in rad, -pi to pi, 0 face up; NaN where the phone stands on end.
 * @param {number} beta
 * @param {number} gamma
 */
export function rollOf(beta, gamma) {
  // where up is, along the phone's x and z (W3C DeviceOrientation: Z-X'-Y'')
  const x = -Math.cos(beta * RAD) * Math.sin(gamma * RAD);
  const z = Math.cos(beta * RAD) * Math.cos(gamma * RAD);
  return Math.hypot(x, z) < UPRIGHT ? NaN : Math.atan2(-x, z);
}

/**
 * Place, 0 to 1, of a roll, when `start` is the roll of the start.
 * @param {number} roll
 * @param {number} start
 */
export function placeOfRoll(roll, start) {
  const turned = Math.abs(roll - start) % (2 * Math.PI);
  return Math.min(turned, 2 * Math.PI - turned) / Math.PI;
}

export class Twist {
  /** @param {Pick<Hand, "hold" | "release">} hand */
  constructor(hand, start = 0) {
    this.hand = hand;
    this.start = start;
    this.roll = NaN;
    this.on = false;
    this.told = false; // whether a sensor has said anything
    /** Called with a line where none does. */
    this.onsilent = /** @type {(line: string) => void} */ (() => {});
    this.heard = (/** @type {DeviceOrientationEvent} */ event) => this.turn(event);
    /** @type {WakeLockSentinel | null} */
    this.lock = null; // on the screen: a page behind a locked one gets no motion
    document.addEventListener("visibilitychange", () => this.keepAwake());
  }

  async keepAwake() {
    if (!this.on || document.hidden) return;
    try {
      this.lock = await navigator.wakeLock?.request("screen");
    } catch {
      this.lock = null; // refused: a low battery
    }
    if (!this.on) this.lock?.release();
  }

  /** Ask where the platform wants that, and begin; an Error in one line if it can't be. */
  async begin() {
    if (!("DeviceOrientationEvent" in window)) throw new Error("this browser has no motion sensor");
    if (!window.isSecureContext) throw new Error("motion needs a page served over https");
    const ask = /** @type {any} */ (window.DeviceOrientationEvent).requestPermission;
    if (ask && (await ask.call(window.DeviceOrientationEvent)) !== "granted") {
      throw new Error("motion was not allowed; allow it in the browser's settings for this page");
    }
    this.on = true;
    this.told = false;
    window.addEventListener("deviceorientation", this.heard);
    this.keepAwake();
    clearTimeout(this.silent);
    this.silent = setTimeout(() => {
      if (this.on && !this.told) this.onsilent("this device tells no motion: drag instead");
    }, SILENT_MS);
  }

  end() {
    this.on = false;
    this.lock?.release();
    window.removeEventListener("deviceorientation", this.heard);
    this.hand.release("twist");
  }

  /** @param {DeviceOrientationEvent} event */
  turn({ beta, gamma, timeStamp }) {
    if (beta === null || gamma === null) return;
    this.told = true;
    const roll = rollOf(beta, gamma);
    if (Number.isNaN(roll)) return;
    this.roll = roll;
    this.hand.hold("twist", placeOfRoll(roll, this.start), timeStamp);
  }

  /** As it is held now is the start; the roll of it, rad. */
  calibrate() {
    if (!Number.isNaN(this.roll)) this.start = this.roll;
    return this.start;
  }
}
