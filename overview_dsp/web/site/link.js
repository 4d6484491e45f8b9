// The WebSocket to the host that plays: events out, how the disk is in. It answers pings at once,
// so that the host knows this page's clock, and repeats a touching hand's last event, so that the
// host knows that the hand is still there.

const REPEAT_MS = 100;
const RETRY_MS = 500;
// Safari opens a page whose certificate one has let pass, but no WebSocket of it
const REFUSED_TIMES = 3;
const REFUSED = "this browser can't connect; an iPhone needs a certificate it trusts (--cert)";
const AT_MOST = 64; // events of a message

/** @import { Status } from "../types" */

/**
 * @typedef {object} LinkTold
 * @property {(connected: boolean, reason: string) => void} onstate
 * @property {(status: Status) => void} onstatus
 * @property {(why: string) => void} onreleased
 */

export class Link {
  /** @type {WebSocket | null} */
  #socket = null;
  /** @type {[number, number, number][]} */
  #waiting = [];
  /** @type {[number, boolean] | null} */
  #last = null; // theta2, touching
  #sentAt = 0;
  #refused = 0; // attempts since the start, while none has succeeded

  /**
   * `onstate(connected, reason)`, `onstatus(status)` and `onreleased(why)` are called.
   * @param {LinkTold} told
   */
  constructor({ onstate, onstatus, onreleased }) {
    this.name = "";
    this.told = { onstate, onstatus, onreleased };
    this.#open();
    setInterval(() => this.#repeat(), REPEAT_MS / 2);
  }

  get connected() {
    return this.#socket?.readyState === WebSocket.OPEN;
  }

  /**
   * One event of the hand: `timeMs` of performance.now(), theta2 in rad.
   * @param {number} timeMs
   * @param {number} theta2
   * @param {boolean} touching
   */
  push(timeMs, theta2, touching) {
    this.#last = [theta2, touching];
    if (!this.connected) return; // a movement that comes late is none
    if (this.#waiting.length === 0) queueMicrotask(() => this.#flush());
    this.#waiting.push([Math.max(timeMs, 0), theta2, touching ? 1 : 0]);
  }

  /**
   * @param {number} startS
   * @param {number} endS
   */
  show(startS, endS) {
    this.#send({ show: [startS, endS] });
  }

  /**
   * Say whose hand this is, now and whenever it connects.
   * @param {string} name
   */
  call(name) {
    this.name = name;
    this.#send({ name });
  }

  #repeat() {
    if (this.#last?.[1] && performance.now() - this.#sentAt >= REPEAT_MS) {
      this.push(performance.now(), ...this.#last);
    }
  }

  #flush() {
    // the host refuses events out of order
    const events = this.#waiting.sort((a, b) => a[0] - b[0]);
    this.#waiting = [];
    for (let i = 0; i < events.length; i += AT_MOST) {
      this.#send({ events: events.slice(i, i + AT_MOST) });
    }
    this.#sentAt = performance.now();
  }

  /** @param {object} message */
  #send(message) {
    if (this.connected) this.#socket.send(JSON.stringify(message));
  }

  #open() {
    const socket = new WebSocket(`${location.origin.replace(/^http/, "ws")}/control`);
    this.#socket = socket;
    socket.onopen = () => {
      this.#refused = -Infinity;
      if (this.name) this.#send({ name: this.name });
      this.told.onstate(true, "");
    };
    socket.onmessage = ({ data }) => {
      const message = JSON.parse(data);
      if ("ping" in message) {
        this.#send({ pong: message.ping, time_ms: performance.now() });
      } else if ("status" in message) {
        this.told.onstatus(message.status);
      } else if ("released" in message) {
        this.told.onreleased(message.released);
      }
    };
    socket.onclose = ({ reason }) => {
      this.#waiting = [];
      this.#refused += 1;
      this.told.onstate(false, this.#refused >= REFUSED_TIMES ? REFUSED : reason);
      setTimeout(() => this.#open(), RETRY_MS);
    };
  }
}
