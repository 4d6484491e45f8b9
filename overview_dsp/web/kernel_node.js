// The page's end of the kernel: an audio node that takes hands, changes and volumes.

import {
  AT_ONCE, CHANGE, checkBytes, METERS, parameterNumber, STRIKE_FIELDS, WHOLE,
} from "./kernel.js";
import { SOURCES } from "./layout.js";

/** @import { HandEvent, Look, Signal } from "./kernel_node" */
/** @typedef {{ over: boolean, meters: Float64Array, strikes: Float64Array }} Answer */

const PROCESSOR = new URL("./processor.js", import.meta.url);
const KERNEL = new URL("./kernel.wasm", import.meta.url);

/**
 * A node that plays a memory image (browser_memory.py) into `context`.
 *
 * `events` and `changes` are there before the first sample: rows as in `KernelNode.control`, and
 * bytes of `encode_change`. Clicks are left, the tactor is right, unless the image's settings say
 * otherwise. One image serves every sample rate. `wasm`: the bytes of `kernel.wasm`, fetched from
 * beside this file if left out. Throws an Error in one line: another version's bytes.
 * @param {BaseAudioContext} context
 * @param {ArrayBuffer} image
 * @param {{ events?: HandEvent[], changes?: ArrayBuffer[], wasm?: Promise<ArrayBuffer> }} given
 */
export async function openKernel(context, image, { events = [], changes = [], wasm: given = fetched() } = {}) {
  const { channels } = checkBytes(image, WHOLE);
  for (const bytes of changes) checkBytes(bytes, CHANGE);
  const [wasm] = await Promise.all([given, context.audioWorklet.addModule(PROCESSOR)]);
  return new KernelNode(context, channels, { wasm, image, events: rows(events), changes });
}

async function fetched() {
  const answer = await fetch(KERNEL);
  if (!answer.ok) throw new Error(`${KERNEL}: ${answer.status} ${answer.statusText}`);
  return answer.arrayBuffer();
}

export class KernelNode extends AudioWorkletNode {
  /**
   * @param {BaseAudioContext} context
   * @param {number} channels
   * @param {object} processorOptions
   */
  constructor(context, channels, processorOptions) {
    super(context, "overview-kernel", {
      numberOfInputs: 0,
      outputChannelCount: [channels],
      processorOptions,
    });
    /** @type {HandEvent[]} */
    this.unsent = [];
    /** @type {((told: Answer) => void)[]} */
    this.asked = [];
    /** Called with a sentence when the audio thread can't do what it was sent. */
    this.onfault = (/** @type {string} */ message) => console.error(message);
    this.port.onmessage = ({ data }) => {
      if (data.kind === "error") this.onfault(data.message);
      else this.asked.shift()(data);
    };
  }

  /**
   * A hand's event: theta2 in rad (0 to pi) and whether it holds on; `sampleTime` counts from the
   * node's first sample. All events of one task go in one message.
   * @param {number} theta2
   * @param {boolean} touching
   */
  control(theta2, touching, source = "touch", sampleTime = AT_ONCE) {
    if (!SOURCES.includes(source)) {
      throw new Error(`no source is called ${source}; known: ${SOURCES.join(", ")}`);
    }
    this.unsent.push({ sampleTime, source, theta2, touching });
    if (this.unsent.length === 1) queueMicrotask(() => this.flush());
  }

  /** Send what waits, so that what is sent after it comes after it. */
  flush() {
    if (this.unsent.length === 0) return;
    const events = rows(this.unsent);
    this.unsent = [];
    this.port.postMessage({ kind: "control", events }, [events.buffer]);
  }

  /**
   * Set a parameter of the preset that isn't the surface's (`tactor.gain_db`), in the preset's unit;
   * a switch is 0 or 1. It glides for 20 ms. Those that aren't set stay the image's.
   * @param {string} id
   * @param {number | boolean} value
   * @param {number} sampleTime
   */
  set(id, value, sampleTime = AT_ONCE) {
    const number = parameterNumber(id, Number(value));
    this.flush();
    this.port.postMessage({ kind: "set", number, value: Number(value), sampleTime });
  }

  /**
   * Bytes of `encode_change`: other parameters, another surface. The buffer goes over.
   * @param {ArrayBuffer} bytes
   */
  change(bytes) {
    const { sampleRate } = checkBytes(bytes, CHANGE);
    if (sampleRate !== this.context.sampleRate) {
      throw new Error(
        `a change for ${sampleRate} Hz; the audio runs at ${this.context.sampleRate} Hz`,
      );
    }
    this.flush();
    this.port.postMessage({ kind: "change", bytes }, [bytes]);
  }

  /**
   * The device's way out of click and tactor: gain and ceiling (linear), delay (s, to 0.1).
   * @param {Signal} click
   * @param {Signal} tactor
   */
  output(click, tactor) {
    const signals = [click, tactor].map(({ gain = 1, ceiling = 1, delay = 0 }) => {
      if (!(gain >= 0 && gain <= 16 && ceiling > 0 && ceiling <= 1 && delay >= 0 && delay <= 0.1)) {
        throw new Error(
          `gain ${gain}, ceiling ${ceiling}, delay ${delay} s; ` +
            "they are 0 to 16, above 0 to 1, 0 to 0.1 s",
        );
      }
      return { gain, ceiling, delay: Math.round(delay * this.context.sampleRate) };
    });
    this.port.postMessage({ kind: "output", signals });
  }

  /**
   * What the kernel tells of itself: meters by name, strikes since the last look, over.
   * @returns {Promise<Look>}
   */
  look() {
    this.flush();
    return new Promise((resolve) => {
      this.asked.push(({ over, meters, strikes }) => {
        const named = Object.fromEntries(METERS.map((name, i) => [name, meters[i]]));
        const told = /** @type {Look} */ (named);
        const struck = [];
        for (let i = 0; i < strikes.length; i += STRIKE_FIELDS) {
          const [sample, event, torque, level] = strikes.subarray(i, i + STRIKE_FIELDS);
          struck.push({ sample, event, torque, level });
        }
        resolve({ ...told, over, struck });
      });
      this.port.postMessage({ kind: "look" });
    });
  }

  /** Fade out and end. */
  stop() {
    this.flush();
    this.port.postMessage({ kind: "stop" });
  }
}

/**
 * Control events as the audio thread takes them.
 * @param {HandEvent[]} events
 */
function rows(events) {
  const table = new Float64Array(4 * events.length);
  events.forEach(({ sampleTime = AT_ONCE, source = "touch", theta2, touching }, i) => {
    table.set([sampleTime, SOURCES.indexOf(source), theta2, touching ? 1 : 0], 4 * i);
  });
  return table;
}
