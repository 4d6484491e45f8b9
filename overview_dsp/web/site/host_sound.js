// The sound of a host: its disk under this page's hand, with the face of `Sound`.

import { Link } from "./link.js";
import { post } from "./session.js";

/** @import { Clock, OtherHand, Part, Preset, Status, Told } from "../types" */

// the host waits until events are as old as the latest was: moves may be drawn out backwards
/** @type {Clock} */
const PAGE_CLOCK = { rate: 1e3, sampleAt: (time) => time, rendering: () => -Infinity };

export class HostSound {
  constructor() {
    this.clock = PAGE_CLOCK;
    /** @type {Status | null} */
    this.status = null;
    this.shown = ""; // the window that the host has
    const nobody = /** @type {(told: any) => void} */ (() => {});
    /** Called with a line on the connection, with one on latency, with [start, end] in s. */
    this.onlink = this.onlatency = this.onshown = this.onstatus = nobody;
    /** Called with the other hands that touch: [{ name, place, holding }]. */
    this.onothers = nobody;
    this.onstate = nobody;
    this.others = "[]";
    this.linked = "connecting";
    this.link = new Link({
      onstate: (connected, reason) => {
        this.say(connected ? "at the host" : reason || "not connected: the disk is free");
        if (!connected) this.onlatency("");
      },
      onreleased: (why) => this.say(why),
      onstatus: (status) => this.take(status),
    });
  }

  /** Tell it all again, to who listens now. */
  tell() {
    this.onlink(this.linked);
    if (this.status !== null) this.onshown(this.status.window);
  }

  /**
   * Whose hand this is.
   * @param {string} name
   */
  call(name) {
    this.link.call(name);
  }

  /** @param {string} text */
  say(text) {
    this.linked = text;
    this.onlink(text);
  }

  get running() {
    return this.status !== null;
  }

  start() {}

  route() {}

  volume() {}

  /**
   * `time`: ms of the page's clock, -1 for now.
   * @param {number} place
   * @param {boolean} touching
   * @param {number} time
   */
  control(place, touching, time) {
    this.link.push(time < 0 ? performance.now() : time, place * Math.PI, touching);
  }

  /** @param {Part} part */
  async show({ start_s, end_s }) {
    return () => this.link.show(start_s, end_s);
  }

  /**
   * @param {Preset} before
   * @param {Preset} after
   */
  async feel(before, after) {
    await post("host/preset", { preset: after });
  }

  /**
   * The host's disk as it was told last.
   * @returns {Promise<Told>}
   */
  async look() {
    const { cursor, touching, torque_nm: torque, envelope } = this.status;
    return { cursor, touching: touching ? 1 : 0, torque, envelope, struck: [] };
  }

  /** @param {Status} status */
  take(status) {
    this.status = status;
    const { round_trip_ms: trip, event_to_sample_ms: sample, output_ms: output } = status;
    this.onlatency(
      trip === null
        ? ""
        : `network ${trip.toFixed(0)} ms` +
            (sample === null ? "" : ` · ${(sample + output).toFixed(0)} ms to sound`),
    );
    const others = JSON.stringify(status.others);
    if (others !== this.others) {
      this.others = others;
      const holder = status.others.find(({ holding }) => holding);
      this.say(holder ? `${holder.name || "another hand"} holds the disk` : "at the host");
      this.onothers(status.others);
    }
    if (status.window.join() !== this.shown) {
      this.shown = status.window.join();
      this.onshown(status.window);
    }
    this.onstatus(status);
  }
}
