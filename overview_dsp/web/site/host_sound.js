// The sound of a host that this page controls, with the interface of `Sound`.

import { Link } from "./link.js";
import { post } from "./session.js";

/** @import { Clock, OtherInput, Part, Preset, Status, DiskState } from "../types" */

// the host delays all events as long as the slowest one, so past movements may be interpolated
/** @type {Clock} */
const PAGE_CLOCK = { rate: 1e3, sampleAt: (time) => time, rendering: () => -Infinity };

export class HostSound {
  constructor() {
    this.clock = PAGE_CLOCK;
    /** @type {Status | null} */
    this.status = null;
    this.lastWindow = ""; // the window that the host shows
    const ignore = /** @type {(value: any) => void} */ (() => {});
    /** Called with a text on the connection, a text on latency, and [start, end] in s. */
    this.onlink = this.onlatency = this.onwindow = this.onstatus = ignore;
    /** Called with the other inputs that touch: [{ name, position, active }]. */
    this.onothers = ignore;
    this.onstate = ignore;
    this.onsilence = () => {};
    this.isSilent = false;
    this.others = "[]";
    this.linkText = "connecting";
    this.link = new Link({
      onstate: (connected, reason) => {
        this.showMessage(connected ? "connected to the host" : reason || "not connected; the disk was released");
        if (!connected) this.onlatency("");
      },
      onreleased: (why) => this.showMessage(why),
      onstatus: (status) => this.onStatus(status),
    });
  }

  /** Report the connection and the window to new handlers. */
  report() {
    this.onlink(this.linkText);
    if (this.status !== null) this.onwindow(this.status.window);
  }

  /**
   * Set the name that other inputs see.
   * @param {string} name
   */
  setName(name) {
    this.link.setName(name);
  }

  /** @param {string} text */
  showMessage(text) {
    this.linkText = text;
    this.onlink(text);
  }

  get running() {
    return this.status !== null;
  }

  get ready() {
    return this.running;
  }

  get rate() {
    return 0;
  }

  async load() {}

  async resume() {}

  start() {}

  route() {}

  volume() {}

  change() {}

  /**
   * Send a control event; `time` is in ms of the page's clock, -1 for now.
   * @param {number} position
   * @param {boolean} touching
   * @param {number} time
   */
  control(position, touching, time) {
    this.link.push(time < 0 ? performance.now() : time, position * Math.PI, touching);
  }

  /** @param {Part} part */
  async show({ start_s, end_s }) {
    return () => this.link.show(start_s, end_s);
  }

  /**
   * @param {Preset} before
   * @param {Preset} after
   */
  async changePreset(before, after) {
    await post("host/preset", { preset: after });
  }

  /**
   * Return the host's last reported state.
   * @returns {Promise<DiskState | null>}
   */
  async readState() {
    if (this.status === null) return null;
    const { cursor, touching, torque_nm: torque, envelope } = this.status;
    return { cursor, touching: touching ? 1 : 0, torque, envelope, newStrikes: [] };
  }

  /** @param {Status} status */
  onStatus(status) {
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
      const other = status.others.find(({ active }) => active);
      this.showMessage(other ? `${other.name || "another input"} controls the disk` : "connected to the host");
      this.onothers(status.others);
    }
    if (status.window.join() !== this.lastWindow) {
      this.lastWindow = status.window.join();
      this.onwindow(status.window);
    }
    this.onstatus(status);
  }
}
