// A timeline that grows: told by the server in a line, fetched when no hand is on the disk.

import { patched } from "./data.js";
import { ask } from "./session.js";
import { eventText } from "./words.js";

/** @import { LiveInfo, Notice, Update, Window } from "../types" */
/** @import { Page } from "./page.js" */

const RATIO = 3; // site_windows.py
const NARROWEST_S = 0.5;

/**
 * The parts of a timeline of some length, as the server cuts them.
 * @param {number} duration
 * @param {number} levels
 * @returns {Window[]}
 */
export function partsOf(duration, levels) {
  const parts = [{ level: 0, start_s: 0, end_s: duration }];
  for (let level = 1; level <= levels; level += 1) {
    const width = duration / RATIO ** level;
    if (width < NARROWEST_S) break;
    const count = 2 * RATIO ** level - 1;
    for (let i = 0; i < count; i += 1) {
      const start_s = Math.min((i * width) / 2, duration - width);
      parts.push({ level, start_s, end_s: i === count - 1 ? duration : start_s + width });
    }
  }
  return parts;
}

/**
 * An update's JSON and its patch.
 * @param {ArrayBuffer} bytes
 */
export function parsed(bytes) {
  const length = new DataView(bytes).getUint32(0, true);
  const head = new TextDecoder().decode(new Uint8Array(bytes, 4, length));
  return { ...JSON.parse(head), patch: bytes.slice(4 + length) };
}

/**
 * Bytes cut, or filled up with 0, to a length.
 * @param {ArrayBuffer | null} bytes
 * @param {number} length
 */
export function resized(bytes, length) {
  const made = new Uint8Array(length);
  if (bytes !== null) made.set(new Uint8Array(bytes, 0, Math.min(bytes.byteLength, length)));
  return made.buffer;
}

/** @param {string} base64 */
const bytesOf = (base64) => Uint8Array.from(atob(base64), (one) => one.charCodeAt(0)).buffer;

export class Live {
  /**
   * @param {Page} page
   * @param {LiveInfo} live
   */
  constructor(page, { levels, version, poll_s }) {
    this.page = page;
    this.levels = levels;
    this.have = -1; // the version of `bytes`
    /** @type {ArrayBuffer | null} */
    this.bytes = null; // the change to the whole's surface
    /** @type {{ info: any, view: any } | null} */
    this.fresh = null; // what of that isn't drawn and felt yet
    /** @type {Notice | null} */
    this.told = null; // the notice that is newest
    this.busy = false;
    page.data.files = false; // those are of a version that has gone
    this.line = document.createElement("p");
    this.line.id = "live";
    this.line.setAttribute("role", "status");
    document.getElementById("window").after(this.line);
    const { hand } = page;
    const { onchange } = hand;
    hand.onchange = () => {
      onchange?.();
      if (hand.holder === null) this.update();
    };
    this.known = version; // of the news
    this.rate = page.atHost ? 0 : null; // null: not known yet, the page is silent
    this.polls = poll_s !== undefined; // a folder: nobody there to ask for a window or a patch
    if (this.polls) this.poll(poll_s);
    else this.listen();
    document.addEventListener("visibilitychange", () => {
      if (!this.polls) this.listen();
      this.update();
    });
  }

  /** Hear of what is new, and, once there is a use for it, have it at once. */
  listen() {
    this.source?.close();
    this.pushed = this.rate !== null && !document.hidden;
    const asked = this.pushed ? `&rate=${this.rate}&have=${this.have}` : "";
    const path = `live/events?since=${this.known}${asked}`;
    this.source = new EventSource(new URL(path, import.meta.url));
    this.source.onmessage = ({ data }) => this.take(JSON.parse(data));
  }

  /**
   * Ask a host for the file that it replaces.
   * @param {number} seconds
   */
  async poll(seconds) {
    try {
      if (!document.hidden) {
        const told = await (await ask("live/now.json", { cache: "no-cache" })).json();
        if (told.version !== this.told?.version) this.take(told);
      }
    } catch (error) {
      this.page.fault(error.message);
    }
    setTimeout(() => this.poll(seconds), seconds * 1000);
  }

  /** @param {Notice} told */
  take(told) {
    this.told = told;
    const { page } = this;
    /** @type {string[]} */
    const lines = [];
    for (const { what, kind, label, time_s, pulse } of told.news.filter((one) => one.version > this.known)) {
      const event = { kind, label, time_s };
      const known = page.info.kinds[kind] !== undefined;
      const words = known ? eventText(event, page.info) : `${kind.replaceAll("_", " ")} ${label}`;
      lines.push(what === "added" ? `new: ${words}` : `taken back: ${words}`);
      const { felt, vibration } = page.settings;
      if (what === "added" && felt === "motor" && vibration && page.hand.holder === null) {
        page.motor.feel([pulse], 0, performance.now());
      }
    }
    this.known = told.version;
    this.line.textContent = [told.words, ...lines.slice(-1)].join(" · ");
    if (lines.length > 0) page.speech.say(lines.at(-1));
    if (told.update) this.keep(parsed(bytesOf(told.update)));
    this.update();
  }

  /** Have what is new under the hand, unless one holds the disk: then when it lets go. */
  async update() {
    const { page } = this;
    const lacks = () => !this.pushed && this.told !== null && this.told.version !== this.have;
    const wanted = () => this.fresh !== null || lacks();
    if (this.busy || document.hidden || !wanted() || page.hand.holder !== null) return;
    this.busy = true;
    try {
      while (wanted() && page.hand.holder === null) {
        if (this.fresh === null) await this.fetch();
        await this.show();
      }
      page.fault("");
    } catch (error) {
      page.fault(error.message);
    } finally {
      this.busy = false;
    }
  }

  async fetch() {
    const { page } = this;
    const { sound } = page;
    if (!page.atHost) await sound.load(); // the change is to what it begins with
    const rate = page.atHost ? 0 : sound.context.sampleRate;
    const path = this.polls
      ? `live/${this.told.version}-${rate}.update`
      : `live/update?since=${this.have}&rate=${rate}`;
    this.keep(parsed(await (await ask(path)).arrayBuffer()));
    if (this.polls || this.rate === rate) return;
    this.rate = rate;
    this.listen();
  }

  /**
   * What came: the bytes are changed at once, the picture and the disk when no hand is there.
   * @param {Update} update
   */
  keep({ version, info, view, rate, bytes, patch }) {
    if (rate > 0) this.bytes = patched(resized(this.bytes, bytes), patch);
    this.have = version;
    this.fresh = { info, view };
  }

  async show() {
    const { page, fresh } = this;
    const { data, shown, sound } = page;
    const { info, view } = fresh;
    const windows = partsOf(info.duration_s, this.levels);
    const whole = { number: 0, zoom: 0, start_s: 0, end_s: info.duration_s };
    const wasWhole = shown.view.zoom === 0 || shown.view.end_s > info.duration_s;
    const part = wasWhole ? whole : { ...shown.view, number: -1 };
    const [drawn, put] =
      wasWhole && data.preset === null
        ? [{ points: null, ...view, ...whole }, () => sound.node?.change(this.bytes.slice(0))]
        : await Promise.all([data.view(part), sound.show(part)]);
    if (page.hand.holder !== null) return; // a hand has come: it keeps what it touched
    if (this.fresh === fresh) this.fresh = null;
    data.whole = null; // the values of the version before
    if (this.polls) data.pointsFile = `live/${this.have}-points.json`;
    Object.assign(page.info, info, { windows });
    shown.windows = windows;
    if (!page.atHost) put();
    shown.under = part;
    shown.take(drawn);
    shown.tell();
    page.tellAbout();
  }
}
