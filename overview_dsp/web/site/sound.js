// The page's sound: an audio context with the kernel in it, and where its two signals go.
// `host_sound.js` has the same face.

import { SampleClock } from "./clock.js";
import { openKernel } from "./kernel_node.js";

/** @import { Part, Preset, Told } from "../types" */
/** @import { KernelNode } from "../kernel_node" */
/** @import { Data } from "./data.js" */

const GLIDE_S = 0.02;

// of each way to feel: how much of click and tactor goes to left and right
/** @type {Record<string, Record<string, [number, number]>>} */
const ROUTES = {
  tactor: { click: [1, 0], tactor: [0, 1] },
  motor: { click: [1, 1], tactor: [0, 0] },
  ears: { click: [1, 1], tactor: [0.5, 0.5] },
};

export class Sound {
  /**
   * Silent until `load` has fetched the kernel and `start` was called; what comes first is kept.
   * @param {Data} data
   */
  constructor(data) {
    this.data = data;
    // iPhones: as music, so that the silent switch doesn't still it
    const { audioSession } = /** @type {any} */ (navigator);
    if (audioSession) audioSession.type = "playback";
    const { rates } = data.info;
    this.context = new AudioContext({ latencyHint: "interactive" });
    if (!rates.includes(this.context.sampleRate)) {
      this.context.close();
      this.context = new AudioContext({ latencyHint: "interactive", sampleRate: rates[0] });
    }
    /** Called where it begins to sound, and where something else takes the output from it. */
    this.onstate = /** @type {(sounds: boolean) => void} */ (() => {});
    this.context.addEventListener("statechange", () => {
      this.onstate(this.context.state === "running");
    });
    this.clock = new SampleClock(this.context.sampleRate);
    /** @type {KernelNode | null} */
    this.node = null;
    this.felt = "ears";
    /** @type {[number, number]} */
    this.gain = [1, 1]; // of click and tactor
    /** @type {number | null} */
    this.held = null; // where a finger holds already
    /** @type {Promise<void> | null} */
    this.loaded = null; // a promise, once it loads
  }

  /** Fetch the kernel and its memory; the promise is of when they are there. */
  load() {
    this.loaded ??= this.open();
    return this.loaded;
  }

  async open() {
    const { context } = this;
    const wasm = this.data.kernel();
    const node = await openKernel(context, await this.data.memory(context.sampleRate), { wasm });
    const split = context.createChannelSplitter(2);
    const merge = context.createChannelMerger(2);
    node.connect(split);
    /** @type {Record<string, GainNode[]>} */
    this.gains = { click: [], tactor: [] };
    Object.values(this.gains).forEach((signal, from) => {
      for (const to of [0, 1]) {
        const gain = context.createGain();
        split.connect(gain, from).connect(merge, 0, to);
        signal.push(gain);
      }
    });
    merge.connect(context.destination);
    this.end = merge;
    this.node = node;
    this.route(this.felt, true);
    this.volume(...this.gain);
    if (this.held !== null) this.control(this.held, true, -1);
  }

  /** In a touch or a key: only then a browser lets a page sound. */
  start() {
    if (this.context.state !== "running") this.context.resume();
  }

  get running() {
    return this.node !== null && this.context.state === "running";
  }

  /**
   * @param {number} place
   * @param {boolean} touching
   * @param {number} sample
   */
  control(place, touching, sample) {
    if (this.node === null) this.held = touching ? place : null;
    else this.node.control(place * Math.PI, touching, "touch", sample);
  }

  /**
   * Where the signals go: tactor, motor or ears.
   * @param {string} felt
   */
  route(felt, atOnce = false) {
    this.felt = felt;
    if (this.node === null) return;
    for (const [signal, levels] of Object.entries(ROUTES[felt])) {
      levels.forEach((level, side) => {
        const { gain } = this.gains[signal][side];
        if (atOnce) gain.value = level;
        else gain.setTargetAtTime(level, this.context.currentTime, GLIDE_S);
      });
    }
  }

  /**
   * Gains of both, linear.
   * @param {number} click
   * @param {number} tactor
   */
  volume(click, tactor) {
    this.gain = [click, tactor];
    this.node?.output({ gain: click }, { gain: tactor });
  }

  /**
   * Fetch what it takes to put a part under the hand; call the answer to do so.
   * @param {Part} part
   */
  async show(part) {
    await this.load();
    const bytes = await this.data.change(part, this.context.sampleRate);
    return () => this.node.change(bytes);
  }

  /**
   * Go from one preset to another; `part` has the surface, null if it stays.
   * @param {Preset} before
   * @param {Preset} after
   * @param {Part | null} part
   */
  async feel(before, after, part) {
    await this.load();
    this.node.change(await this.data.feel(before, after, part, this.context.sampleRate));
  }

  /**
   * The kernel's meters and strikes.
   * @returns {Promise<Told>}
   */
  async look() {
    const told = await this.node.look();
    this.clock.heard(told.clock, performance.now());
    return told;
  }
}
