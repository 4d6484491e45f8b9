// The WebSocket to the host: it sends control events and receives the disk's status. It answers pings,
// from which the host measures this page's clock. While the input touches, it repeats the last event:
// the host releases an input that stays silent.

const REPEAT_MS = 100;
const RETRY_MS = 500;
// Safari opens a page with an accepted certificate, but no WebSocket
const MAX_FAILURES = 3;
const REFUSED = "this browser can't connect; an iPhone needs a trusted certificate (--cert)";
const MAX_EVENTS = 64; // events per message

/** @import { Status } from "../types" */

/**
 * @typedef {object} LinkHandlers
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
  #lastEvent = null; // theta2, touching
  #sentAt = 0;
  #failures = 0; // failed attempts since the start; negative after a success

  /**
   * The handlers are called as the connection changes and as messages arrive.
   * @param {LinkHandlers} handlers
   */
  constructor({ onstate, onstatus, onreleased }) {
    this.name = "";
    this.handlers = { onstate, onstatus, onreleased };
    this.#open();
    setInterval(() => this.#repeat(), REPEAT_MS / 2);
  }

  get connected() {
    return this.#socket?.readyState === WebSocket.OPEN;
  }

  /**
   * Queue one control event: `timeMs` of performance.now(), theta2 in rad.
   * @param {number} timeMs
   * @param {number} theta2
   * @param {boolean} touching
   */
  push(timeMs, theta2, touching) {
    this.#lastEvent = [theta2, touching];
    if (!this.connected) return; // a late movement is useless
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

  /** Set a mark at the disk. */
  mark() {
    this.#send({ mark: "" });
  }

  /**
   * Send the input's name, now and after each connection.
   * @param {string} name
   */
  setName(name) {
    this.name = name;
    this.#send({ name });
  }

  #repeat() {
    if (this.#lastEvent?.[1] && performance.now() - this.#sentAt >= REPEAT_MS) {
      this.push(performance.now(), ...this.#lastEvent);
    }
  }

  #flush() {
    // the host rejects events out of order
    const events = this.#waiting.sort((a, b) => a[0] - b[0]);
    this.#waiting = [];
    for (let i = 0; i < events.length; i += MAX_EVENTS) {
      this.#send({ events: events.slice(i, i + MAX_EVENTS) });
    }
    this.#sentAt = performance.now();
  }

  /** @param {object} message */
  #send(message) {
    if (this.connected) this.#socket?.send(JSON.stringify(message));
  }

  #open() {
    const socket = new WebSocket(`${location.origin.replace(/^http/, "ws")}/control`);
    this.#socket = socket;
    socket.onopen = () => {
      this.#failures = -Infinity;
      if (this.name) this.#send({ name: this.name });
      this.handlers.onstate(true, "");
    };
    socket.onmessage = ({ data }) => {
      const message = JSON.parse(data);
      if ("ping" in message) {
        this.#send({ pong: message.ping, time_ms: performance.now() });
      } else if ("status" in message) {
        this.handlers.onstatus(message.status);
      } else if ("released" in message) {
        this.handlers.onreleased(message.released);
      }
    };
    socket.onclose = ({ reason }) => {
      this.#waiting = [];
      this.#failures += 1;
      this.handlers.onstate(false, this.#failures >= MAX_FAILURES ? REFUSED : reason);
      setTimeout(() => this.#open(), RETRY_MS);
    };
  }
}
