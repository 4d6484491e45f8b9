// A live timeline: the server sends notices, and the page updates while the disk isn't touched.

import { patched } from "./data.js";
import { byId, made } from "./dom.js";
import { MissedEvents } from "./missed.js";
import { readableTitle } from "./scores.js";
import { request } from "./session.js";
import { unpacked } from "./unpack.js";
import { eventText } from "./descriptions.js";
import { NEW, WITHDRAWN } from "./page_words.js";

/** @import { LiveInfo, LiveParts, NewVersion, Notice, Update, View, Window } from "../types" */

const RATIO = 3; // as in site_data.py
const NARROWEST_S = 0.5;

/**
 * Return the windows of a timeline of a given duration, as the server makes them.
 * @param {number} duration
 * @param {number} levels
 * @returns {Window[]}
 */
export function windowsOf(duration, levels) {
  const windows = [{ level: 0, start_s: 0, end_s: duration }];
  for (let level = 1; level <= levels; level += 1) {
    const width = duration / RATIO ** level;
    if (width < NARROWEST_S) break;
    const count = 2 * RATIO ** level - 1;
    for (let i = 0; i < count; i += 1) {
      const start_s = Math.min((i * width) / 2, duration - width);
      windows.push({ level, start_s, end_s: i === count - 1 ? duration : start_s + width });
    }
  }
  return windows;
}

/**
 * Return an update's JSON fields and its patch.
 * @param {ArrayBuffer} bytes
 * @returns {Update}
 */
export function parsed(bytes) {
  const length = new DataView(bytes).getUint32(0, true);
  const head = new TextDecoder().decode(new Uint8Array(bytes, 4, length));
  return { ...JSON.parse(head), patch: bytes.slice(4 + length) };
}

/**
 * Return the bytes cut, or padded with 0, to a length.
 * @param {ArrayBuffer | null} bytes
 * @param {number} length
 */
export function resized(bytes, length) {
  const result = new Uint8Array(length);
  if (bytes !== null) result.set(new Uint8Array(bytes, 0, Math.min(bytes.byteLength, length)));
  return result.buffer;
}

/** @param {string} base64 */
const bytesOf = (base64) => Uint8Array.from(atob(base64), (one) => one.charCodeAt(0)).buffer;

export class Live {
  /**
   * @param {LiveParts} parts
   * @param {LiveInfo} live
   */
  constructor(parts, { levels, version, poll_s }) {
    this.parts = parts;
    this.levels = levels;
    this.loadedVersion = -1; // version of `bytes`
    /** @type {Promise<ArrayBuffer | null>} */
    this.bytes = Promise.resolve(null); // change to the surface of the whole timeline
    /** @type {NewVersion | null} */
    this.pending = null; // update that isn't applied yet
    /** @type {Notice | null} */
    this.notice = null; // newest notice
    this.busy = false;
    parts.data.usesFiles = false; // the files are of an earlier version
    this.line = made("p", { id: "live" });
    this.line.setAttribute("role", "status");
    byId("window").after(this.line);
    this.missed = new MissedEvents(parts, this.line);
    const { input } = parts;
    const { onchange } = input;
    input.onchange = () => {
      onchange?.();
      this.missed.afterInput();
      if (input.active === null) this.update();
    };
    this.seenVersion = version; // newest version whose changes were announced
    this.rate = parts.atHost ? 0 : null; // null: unknown while the page is silent
    this.polls = poll_s !== undefined; // a static folder: no server makes windows or patches
    if (poll_s === undefined) this.listen();
    else this.poll(poll_s);
    document.addEventListener("visibilitychange", () => {
      if (!this.polls) this.listen();
      this.update();
    });
  }

  /** Receive notices, with their updates once the sample rate is known. */
  listen() {
    this.source?.close();
    this.pushed = this.rate !== null && !document.hidden; // notices contain their updates
    const query = this.pushed ? `&rate=${this.rate}&have=${this.loadedVersion}` : "";
    const path = `live/events?since=${this.seenVersion}${query}`;
    this.source = new EventSource(new URL(path, import.meta.url));
    this.source.onmessage = ({ data }) => this.onNotice(JSON.parse(data));
  }

  /**
   * Request the notice of a static folder at a regular interval.
   * @param {number} seconds
   */
  async poll(seconds) {
    try {
      if (!document.hidden) {
        const notice = await (await request("live/now.json", { cache: "no-cache" })).json();
        if (notice.version !== this.notice?.version) this.onNotice(notice);
      }
    } catch (error) {
      this.parts.actions.fault(error.message);
    }
    setTimeout(() => this.poll(seconds), seconds * 1000);
  }

  /** @param {Notice} notice */
  onNotice(notice) {
    this.notice = notice;
    const { info, input, motor, settings, speech } = this.parts;
    /** @type {string[]} */
    const lines = [];
    for (const { action, kind, label, change, time_s, pattern } of notice.changes.filter((one) => one.version > this.seenVersion)) {
      const event = { kind, label, change, time_s };
      const isKnown = info.kinds[kind] !== undefined;
      const text = isKnown ? eventText(event, info) : `${kind.replaceAll("_", " ")} ${label}`;
      this.missed.change(action, event);
      const word = action === "added" ? NEW : WITHDRAWN;
      lines.push(kind === "withdrawn_goal" ? text : word + text);
      const { output, vibration } = settings;
      if (action === "added" && output === "motor" && vibration && input.active === null) {
        motor.play([pattern], 0, performance.now());
      }
    }
    this.seenVersion = notice.version;
    const newest = lines.slice(-1);
    this.line.textContent = [notice.status_text, ...newest].join(" · ");
    newest.forEach((line) => speech.speak(line));
    if (notice.update) this.storeUpdate(parsed(bytesOf(notice.update)));
    this.update();
  }

  /** The version that this page has yet to request, or null. */
  get missingVersion() {
    const version = this.notice?.version ?? this.loadedVersion;
    return this.pushed || version === this.loadedVersion ? null : version;
  }

  /** Apply the newest version, unless the disk is touched; then after the release. */
  async update() {
    const { actions, input } = this.parts;
    const hasUpdate = this.pending !== null || this.missingVersion !== null;
    if (this.busy || document.hidden || !hasUpdate || input.active !== null) return;
    this.busy = true;
    try {
      while (input.active === null) {
        const version = this.missingVersion;
        if (this.pending === null && version !== null) await this.fetch(version);
        if (this.pending === null) break;
        await this.show(this.pending);
      }
      actions.fault("");
    } catch (error) {
      actions.fault(error.message);
    } finally {
      this.busy = false;
    }
  }

  /** @param {number} version */
  async fetch(version) {
    const { sound } = this.parts;
    await sound.load(); // the change applies to the initial memory
    const { rate } = sound;
    const path = this.polls
      ? `live/${version}-${rate}.update`
      : `live/update?since=${this.loadedVersion}&rate=${rate}`;
    this.storeUpdate(parsed(await (await request(path)).arrayBuffer()));
    if (this.polls || this.rate === rate) return;
    this.rate = rate;
    this.listen();
  }

  /**
   * Store an update; picture and disk change once the disk isn't touched.
   * @param {Update} update
   */
  storeUpdate({ version, info, view, rate, bytes, packed, patch }) {
    if (packed) this.bytes = unpacked(patch);
    else if (rate > 0) this.bytes = this.bytes.then((base) => patched(resized(base, bytes), patch));
    this.loadedVersion = version;
    this.pending = { info, view };
  }

  /** @param {NewVersion} pending */
  async show(pending) {
    const { atHost, data, input, sound, viewState } = this.parts;
    const { info, view } = pending;
    const windows = windowsOf(info.duration_s, this.levels);
    const whole = { number: 0, zoom: 0, start_s: 0, end_s: info.duration_s };
    const wasWhole = viewState.view.zoom === 0 || viewState.view.end_s > info.duration_s;
    const part = wasWhole ? whole : { ...viewState.view, number: -1 };
    const changed = await this.bytes;
    const latest = data.finished({ points: null, ...view, ...whole }, null);
    /** @type {[View, () => void]} */
    const [drawn, apply] =
      wasWhole && data.preset === null
        ? [latest, () => changed && sound.change(changed.slice(0))]
        : await Promise.all([data.view(part), sound.show(part)]);
    if (input.active !== null) return; // a touched disk keeps its data
    if (this.pending === pending) this.pending = null;
    data.allPoints = null; // values of the earlier version
    if (this.polls) data.pointsFile = `live/${this.loadedVersion}-points.json`;
    Object.assign(this.parts.info, info, { windows, title: readableTitle(info.title) });
    viewState.windows = windows;
    if (!atHost) apply();
    viewState.soundingPart = part;
    viewState.setView(drawn);
    viewState.updateControls();
    this.parts.showAbout();
  }
}
