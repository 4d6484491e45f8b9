// The answers of a session: kept in this browser first, sent again and again until the server has
// them. What is kept is never asked for again; what the server has stored first stays.

import { Refused } from "./client.js";

const FIRST_WAIT_MS = 500;
const LONGEST_WAIT_MS = 8000;

/** What the steps need to know of an answer. */
const known = ({ response, correct = null, stimulus = null, level = null }) =>
  ({ response, correct, stimulus, level });

export class Answers {
  /**
   * `send(id, row)` is fulfilled when the server has stored it; null where there is no server.
   * `onchange()` is called when the number of unsent ones changes, `onrefused(line)` when the server
   * will never take one.
   */
  constructor(kept, session, send, { onchange = () => {}, onrefused = /** @type {(line: string) => void} */ (() => {}),
    wait = later } = {}) {
    this.kept = kept;
    this.prefix = `row ${session}/`;
    this.send = send;
    this.onchange = onchange;
    this.onrefused = onrefused;
    this.wait = wait;
    this.done = new Map(); // of each answered id what is known of it
    this.unsent = new Map(); // rows by id, in the order of their coming
    this.sending = null; // a promise while it sends
  }

  /** Take over what this browser has kept and what the server has (`answers` of a session). */
  async open(stored = {}) {
    const rows = await this.rows();
    for (const [id, { row, sent }] of rows) {
      this.done.set(id, known(row));
      if (!sent && !Object.hasOwn(stored, id)) this.unsent.set(id, row);
    }
    // what the server stored first stays
    for (const [id, told] of Object.entries(stored)) this.done.set(id, known(told));
    this.number = rows.length;
    this.start();
  }

  has(id) {
    return this.done.has(id);
  }

  /** Keep an answer; it counts once the promise is fulfilled. A second one of an id is none. */
  async add(id, row) {
    if (this.done.has(id)) return;
    this.done.set(id, known(row));
    const entry = { number: this.number, received_utc: new Date().toISOString(), row, sent: false };
    this.number += 1;
    try {
      await this.kept.put(this.prefix + id, entry);
    } catch (error) {
      this.done.delete(id);
      throw error;
    }
    if (this.send === null) return;
    this.unsent.set(id, row);
    this.onchange();
    this.start();
  }

  /** All rows that were kept: [id, { received_utc, row, sent }], in the order of their coming. */
  async rows() {
    const kept = await this.kept.entries(this.prefix);
    kept.sort(([, a], [, b]) => a.number - b.number);
    return kept.map(([key, entry]) => [key.slice(this.prefix.length), entry]);
  }

  /** Send all rows once more, as if none had been; how many. */
  async sendAgain() {
    const rows = await this.rows();
    for (const [id, { row }] of rows) this.unsent.set(id, row);
    this.start();
    return rows.length;
  }

  /** When nothing waits any more. */
  async sent() {
    while (this.unsent.size > 0) await this.start();
  }

  /** Try at once what waits for its next turn. */
  hurry() {
    this.wait.now?.();
  }

  start() {
    if (this.send === null || this.unsent.size === 0) return this.sending;
    this.sending ??= this.run().finally(() => {
      this.sending = null;
    });
    return this.sending;
  }

  async run() {
    let pause = FIRST_WAIT_MS;
    while (this.unsent.size > 0) {
      const [id, row] = this.unsent.entries().next().value;
      try {
        await this.send(id, row);
      } catch (error) {
        if (error instanceof Refused) this.onrefused(error.message);
        await this.wait(error instanceof Refused ? LONGEST_WAIT_MS : pause);
        pause = Math.min(2 * pause, LONGEST_WAIT_MS);
        continue;
      }
      pause = FIRST_WAIT_MS;
      this.unsent.delete(id);
      const entry = await this.kept.get(this.prefix + id);
      if (entry) await this.kept.put(this.prefix + id, { ...entry, sent: true });
      this.onchange();
    }
  }
}

/** So many ms, or until `later.now` is called. */
function later(ms) {
  return new Promise((resolve) => {
    const timer = setTimeout(resolve, ms);
    later.now = () => {
      clearTimeout(timer);
      resolve(undefined);
    };
  });
}
later.now = () => {};
