// The timeline's files: JSON for the picture, bytes for the kernel. A static folder has files of some
// windows and one preset. A server makes them for any window and preset (`info.server`).

import { copyScores, readableTitle, setScores } from "./scores.js";
import { request, openSession, post } from "./session.js";
import { inflated, unpacked } from "./unpack.js";
import { partOf } from "./windows.js";

/** @import { Info, Part, Points, Preset, View } from "../types" */

/** @param {string} path */
const json = async (path) => (await request(path)).json();
/** @param {string} path */
const bytes = async (path) => (await request(path)).arrayBuffer();

export class Data {
  /** @param {Info} info */
  constructor(info) {
    this.info = info;
    /** The active preset, if it isn't that of the files. */
    this.preset = /** @type {Preset | null} */ (null);
    /** Whether the files are current; false for a live timeline. */
    this.usesFiles = true;
    /** The file with all values of a live timeline. */
    this.pointsFile = "data/points-0.json";
    /** The values of all windows, once they are loaded. */
    this.allPoints = /** @type {Points | null} */ (null);
    /** The whole timeline, once it is loaded. */
    this.whole = /** @type {View | null} */ (null);
  }

  static async open() {
    await openSession();
    const info = await json("data/timeline.json");
    info.title = readableTitle(info.title);
    return new Data(info);
  }

  /**
   * Return the contents of a part.
   * @param {Part} part
   * @returns {Promise<View>}
   */
  async view(part) {
    const loaded = this.hasFile(part)
      ? json(`data/window-${part.number}.json`)
      : post("data/window", { window: ends(part), ...this.presetField("preset") }).then((answer) => answer.json());
    const whole = part.number === 0 ? null : this.whole ?? this.view(partOf(this.info.windows, 0));
    const [content, from] = await Promise.all([loaded, whole]);
    return this.finished({ points: this.allPoints, ...content, ...part }, from);
  }

  /**
   * Return a view with the scores of its goals; the whole timeline (whose `whole` is null) is kept.
   * @param {View} view
   * @param {View | null} whole
   */
  finished(view, whole) {
    if (whole) copyScores(view, whole.events);
    else {
      setScores(view.events);
      this.whole = view;
    }
    return view;
  }

  /**
   * Return the data values of a part; null for data without values.
   * @param {View} view
   * @returns {Promise<Points | null>}
   */
  async points(view) {
    const { series } = this.info;
    if (!series || view.points) return view.points ?? null;
    if (!series.complete && this.usesFiles) return json(`data/points-${view.number}.json`);
    this.allPoints ??= await json(this.pointsFile);
    return this.allPoints;
  }

  /**
   * Return the kernel's memory for a sample rate, with the whole timeline.
   * @param {number} rate
   */
  memory(rate) {
    return this.sound("0", rate);
  }

  /**
   * Return the change to a part's surface.
   * @param {Part} part
   * @param {number} rate
   */
  change(part, rate) {
    if (!this.hasFile(part)) {
      const presets = { ...this.presetField("before"), ...this.presetField("after") };
      return fetchChange({ sample_rate: rate, window: ends(part), ...presets });
    }
    return this.sound(part.number === 0 ? "back" : String(part.number), rate);
  }

  /**
   * Return the change between two presets, with a part's surface or (null) without.
   * @param {Preset} before
   * @param {Preset} after
   * @param {Part | null} part
   * @param {number} rate
   */
  presetChange(before, after, part, rate) {
    const surface = part === null ? {} : { window: ends(part) };
    return fetchChange({ sample_rate: rate, before, after, ...surface });
  }

  /** @param {Part} part */
  hasFile({ number }) {
    return this.usesFiles && number >= 0 && this.preset === null;
  }

  /** @param {string} key */
  presetField(key) {
    return this.preset === null ? {} : { [key]: this.preset };
  }

  /** Return the bytes of `kernel.wasm`. */
  kernel() {
    return bytes("kernel.deflated").then(inflated);
  }

  /**
   * @param {string} name
   * @param {number} rate
   */
  async sound(name, rate) {
    const [first] = this.info.rates;
    const base = bytes(`sound/${name}.packed`).then(unpacked);
    if (rate === first) return base;
    return patched(...(await Promise.all([base, bytes(`sound/${name}-${rate}.patch`)])));
  }
}

/** @param {Part} part */
const ends = ({ start_s, end_s }) => [start_s, end_s];

/** @param {object} query */
const fetchChange = async (query) => (await post("sound/change", query)).arrayBuffer();

/**
 * Return the bytes with some columns replaced (sound_data.py documents the format).
 * @param {ArrayBuffer} base
 * @param {ArrayBuffer} patch
 */
export function patched(base, patch) {
  const words = new Uint32Array(patch);
  if (words[0] === 1) return patch.slice(8);
  const result = new Uint32Array(base.slice(0));
  let at = 2;
  for (let run = 0; run < words[1]; run += 1) {
    const column = words[at];
    const count = words[at + 1];
    result.set(words.subarray(at + 2, at + 2 + 2 * count), 2 * column);
    at += 2 + 2 * count;
  }
  return result.buffer;
}
