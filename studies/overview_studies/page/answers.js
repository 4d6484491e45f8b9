// Answers of a session. They are stored in this browser first, then sent until the server has stored
// them. An answered trial is never repeated; the first row on the server is final.

import { Refused } from "./client.js";

const FIRST_WAIT_MS = 500;
const LONGEST_WAIT_MS = 8000;

/** Return the parts of an answer that later steps use. */
const resultOf = ({ response, correct = null, stimulus = null, level = null }) =>
  ({ response, correct, stimulus, level });

export class Answers {
  /**
   * `send(id, row)` resolves when the server has stored the row; null without a server. `onchange()` is
   * called when the number of unsent rows changes, `onrefused(line)` when the server rejects a row.
   */
  constructor(store, session, send, { onchange = () => {}, onrefused = /** @type {(line: string) => void} */ (() => {}),
    wait = later } = {}) {
    this.store = store;
    this.prefix = `row ${session}/`;
    this.send = send;
    this.onchange = onchange;
    this.onrefused = onrefused;
    this.wait = wait;
    this.done = new Map(); // results by answered id
    this.unsent = new Map(); // rows by id, in order
    this.sending = null; // a promise while rows are sent
  }

  /** Load the rows of this browser and of the server (`answers` of a session). */
  async open(stored = {}) {
    const rows = await this.rows();
    for (const [id, { row, sent }] of rows) {
      this.done.set(id, resultOf(row));
      if (!sent && !Object.hasOwn(stored, id)) this.unsent.set(id, row);
    }
    // the first row on the server is final
    for (const [id, answer] of Object.entries(stored)) this.done.set(id, resultOf(answer));
    this.number = rows.length;
    this.start();
  }

  has(id) {
    return this.done.has(id);
  }

  /** Store an answer; it is valid once the promise resolves. Further answers of an id are ignored. */
  async add(id, row) {
    if (this.done.has(id)) return;
    this.done.set(id, resultOf(row));
    const entry = { number: this.number, received_utc: new Date().toISOString(), row, sent: false };
    this.number += 1;
    try {
      await this.store.put(this.prefix + id, entry);
    } catch (error) {
      this.done.delete(id);
      throw error;
    }
    if (this.send === null) return;
    this.unsent.set(id, row);
    this.onchange();
    this.start();
  }

  /** Return all stored rows in order: [id, { received_utc, row, sent }]. */
  async rows() {
    const entries = await this.store.entries(this.prefix);
    entries.sort(([, a], [, b]) => a.number - b.number);
    return entries.map(([key, entry]) => [key.slice(this.prefix.length), entry]);
  }

  /** Send all rows again; return their number. */
  async sendAgain() {
    const rows = await this.rows();
    for (const [id, { row }] of rows) this.unsent.set(id, row);
    this.start();
    return rows.length;
  }

  /** Wait until all rows are sent. */
  async sent() {
    while (this.unsent.size > 0) await this.start();
  }

  /** Retry immediately instead of after the current delay. */
  retryNow() {
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
      const [[id, row]] = this.unsent;
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
      const entry = await this.store.get(this.prefix + id);
      if (entry) await this.store.put(this.prefix + id, { ...entry, sent: true });
      this.onchange();
    }
  }
}

/** Wait `ms` milliseconds, or until `later.now` is called. */
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
