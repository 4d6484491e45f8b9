// The page's own sound: an audio context with the kernel, and the routing of its two signals.
// `host_sound.js` has the same interface.

import { SampleClock } from "./clock.js";
import { openKernel } from "./kernel_node.js";

/** @import { Part, Preset, DiskState } from "../types" */
/** @import { KernelNode } from "../kernel_node" */
/** @import { Data } from "./data.js" */

const GLIDE_S = 0.02;
const SILENT_MS = 2000; // longer than a working sound output needs to start
const FOLLOW = 0.25; // part of the way that a disk without sound moves in a frame

// per output: gains of click and tactor to the left and right channel
/** @type {Record<string, Record<string, [number, number]>>} */
const ROUTES = {
  tactor: { click: [1, 0], tactor: [0, 1] },
  motor: { click: [1, 1], tactor: [0, 0] },
  ears: { click: [1, 1], tactor: [0.5, 0.5] },
};

export class Sound {
  /**
   * The sound is silent until `load` has loaded the kernel and `start` was called.
   * @param {Data} data
   */
  constructor(data) {
    this.data = data;
    // on iPhones the silent switch doesn't mute music
    const { audioSession } = /** @type {any} */ (navigator);
    if (audioSession) audioSession.type = "playback";
    const { rates } = data.info;
    this.context = new AudioContext({ latencyHint: "interactive" });
    if (!rates.includes(this.context.sampleRate)) {
      this.context.close();
      this.context = new AudioContext({ latencyHint: "interactive", sampleRate: rates[0] });
    }
    /** Called when the sound starts, and when another program interrupts it. */
    this.onstate = /** @type {(sounds: boolean) => void} */ (() => {});
    /** Called when no sound output starts. */
    this.onsilence = () => {};
    this.isSilent = false; // whether no output has started: the disk then follows the input
    this.context.addEventListener("statechange", () => {
      const isRunning = this.context.state === "running";
      if (isRunning) this.endSilence();
      this.onstate(isRunning);
    });
    this.clock = new SampleClock(this.context.sampleRate);
    /** @type {KernelNode | null} */
    this.node = null;
    this.output = "ears";
    /** @type {[number, number]} */
    this.gain = [1, 1]; // of click and tactor
    this.held = { position: 0, touching: false }; // the last touch
    this.cursor = 0; // position of a disk without sound
    /** @type {Promise<void> | null} */
    this.silence = null; // settled once it is known whether an output starts
    /** @type {Promise<void> | null} */
    this.loaded = null; // set once loading has begun
  }

  /** Load the kernel and its memory. */
  load() {
    this.loaded ??= this.open();
    return this.loaded;
  }

  async open() {
    const { context } = this;
    const memory = this.data.memory(context.sampleRate);
    const node = await openKernel(context, memory, { wasm: this.data.kernel() });
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

    this.node = node;
    this.route(this.output, true);
    this.volume(...this.gain);
    if (this.held.touching) this.control(this.held.position, true, -1);
  }

  /** Start the sound; browsers allow that only in a touch, a key press or a click. */
  start() {
    if (this.context.state === "running") return;
    this.context.resume();
    this.silence ??= this.awaitSilence();
  }

  /** Wait until it is known whether an output starts. */
  async awaitSilence() {
    await this.load();
    await new Promise((resolve) => setTimeout(resolve, SILENT_MS));
    this.isSilent = this.context.state !== "running";
    if (this.isSilent) this.onsilence();
    else this.silence = null;
  }

  /** An output has started. */
  endSilence() {
    this.silence = null;
    if (!this.isSilent) return;
    this.isSilent = false;
    this.control(this.held.position, this.held.touching, -1);
  }

  /** Wait until the output runs, or none has started. */
  async resume() {
    this.start();
    await Promise.race([this.context.resume(), this.silence]);
  }

  get rate() {
    return this.context.sampleRate;
  }

  get ready() {
    return this.node !== null;
  }

  get running() {
    return this.node !== null && (this.context.state === "running" || this.isSilent);
  }

  setName() {}

  /**
   * @param {number} position
   * @param {boolean} touching
   * @param {number} sample
   */
  control(position, touching, sample) {
    this.held = { position, touching };
    if (!this.isSilent) this.node?.control(position * Math.PI, touching, "touch", sample);
  }

  /**
   * Route the signals to tactor, motor or ears.
   * @param {string} output
   */
  route(output, atOnce = false) {
    this.output = output;
    if (this.node === null) return;
    for (const [signal, levels] of Object.entries(ROUTES[output])) {
      levels.forEach((level, side) => {
        const { gain } = this.gains[signal][side];
        if (atOnce) gain.value = level;
        else gain.setTargetAtTime(level, this.context.currentTime, GLIDE_S);
      });
    }
  }

  /**
   * Set the gains of click and tactor, linear.
   * @param {number} click
   * @param {number} tactor
   */
  volume(click, tactor) {
    this.gain = [click, tactor];
    this.node?.output({ gain: click }, { gain: tactor });
  }

  /**
   * Load the surface of a part; the returned function applies it.
   * @param {Part} part
   */
  async show(part) {
    await this.load();
    const bytes = await this.data.change(part, this.context.sampleRate);
    return () => this.change(bytes);
  }

  /**
   * Apply a change to the kernel's memory.
   * @param {ArrayBuffer} bytes
   */
  change(bytes) {
    this.node?.change(bytes);
  }

  /**
   * Change from one preset to another; `part` has the surface, null if it stays.
   * @param {Preset} before
   * @param {Preset} after
   * @param {Part | null} part
   */
  async changePreset(before, after, part) {
    await this.load();
    this.change(await this.data.presetChange(before, after, part, this.context.sampleRate));
  }

  /**
   * Return the kernel's meters and strikes.
   * @returns {Promise<DiskState | null>}
   */
  async readState() {
    if (this.node === null) return null;
    if (this.isSilent) {
      const { position, touching } = this.held;
      this.cursor += FOLLOW * ((touching ? position : 0) - this.cursor);
      return { cursor: this.cursor, touching: Number(touching), torque: 0, envelope: 0, newStrikes: [] };
    }
    const state = await this.node.readState();
    this.clock.addReading(state.clock, performance.now());
    return state;
  }
}
