// The timeline's files: what is drawn (JSON) and what sounds (bytes for the kernel). A folder has
// them for some windows and one preset; a server makes them for any (`info.server`).

import { ask, enter, post } from "./session.js";
import { inflated, unpacked } from "./unpack.js";

/** @import { Info, Part, Points, Preset, View } from "../types" */

/** @param {string} path */
const json = async (path) => (await ask(path)).json();
/** @param {string} path */
const bytes = async (path) => (await ask(path)).arrayBuffer();

export class Data {
  /** @param {Info} info */
  constructor(info) {
    this.info = info;
    /** What it is felt by, where that isn't the preset of the files. */
    this.preset = /** @type {Preset | null} */ (null);
    /** Whether the files are what is felt: not of a timeline that has grown. */
    this.files = true;
    /** Where all values of a timeline that grows are. */
    this.pointsFile = "data/points-0.json";
    /** The values of all windows, once they are there. */
    this.whole = /** @type {Points | null} */ (null);
  }

  static async open() {
    await enter();
    return new Data(await json("data/timeline.json"));
  }

  /**
   * What is drawn of a part.
   * @param {Part} part
   * @returns {Promise<View>}
   */
  async view(part) {
    const drawn = this.hasFile(part)
      ? await json(`data/window-${part.number}.json`)
      : await (await post("data/window", { window: ends(part), ...this.by("preset") })).json();
    return { points: this.whole, ...drawn, ...part };
  }

  /**
   * The values of a part, where it has some that it hasn't got yet (`values.js`).
   * @param {View} view
   * @returns {Promise<Points | null>}
   */
  async points(view) {
    const { series } = this.info;
    if (!series || view.points) return view.points ?? null;
    if (!series.whole && this.files) return json(`data/points-${view.number}.json`);
    this.whole ??= await json(this.pointsFile);
    return this.whole;
  }

  /**
   * The kernel's memory at a sample rate, over the whole timeline.
   * @param {number} rate
   */
  memory(rate) {
    return this.sound("0", rate);
  }

  /**
   * A change to a part.
   * @param {Part} part
   * @param {number} rate
   */
  change(part, rate) {
    if (!this.hasFile(part)) {
      const presets = { ...this.by("before"), ...this.by("after") };
      return changed({ sample_rate: rate, window: ends(part), ...presets });
    }
    return this.sound(part.number === 0 ? "back" : String(part.number), rate);
  }

  /**
   * A change from one preset to another, with a part's surface or (null) without.
   * @param {Preset} before
   * @param {Preset} after
   * @param {Part | null} part
   * @param {number} rate
   */
  feel(before, after, part, rate) {
    const surface = part === null ? {} : { window: ends(part) };
    return changed({ sample_rate: rate, before, after, ...surface });
  }

  /** @param {Part} part */
  hasFile({ number }) {
    return this.files && number >= 0 && this.preset === null;
  }

  /** @param {string} key */
  by(key) {
    return this.preset === null ? {} : { [key]: this.preset };
  }

  /** `kernel.wasm`. */
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

/** @param {object} asked */
const changed = async (asked) => (await post("sound/change", asked)).arrayBuffer();

/**
 * Bytes with some columns replaced (sound_data.py says how).
 * @param {ArrayBuffer} base
 * @param {ArrayBuffer} patch
 */
export function patched(base, patch) {
  const words = new Uint32Array(patch);
  if (words[0] === 1) return patch.slice(8);
  const made = new Uint32Array(base.slice(0));
  let at = 2;
  for (let run = 0; run < words[1]; run += 1) {
    const column = words[at];
    const count = words[at + 1];
    made.set(words.subarray(at + 2, at + 2 + 2 * count), 2 * column);
    at += 2 + 2 * count;
  }
  return made.buffer;
}
