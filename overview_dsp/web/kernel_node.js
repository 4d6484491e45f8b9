// The audio node of the kernel: control events, parameters, changes and volumes.

import {
  AT_ONCE, CHANGE, checkBytes, METERS, parameterNumber, STRIKE_FIELDS, WHOLE,
} from "./kernel.js";
import { SOURCES } from "./layout.js";

/** @import { ControlEvent, KernelState, Signal } from "./kernel_node" */
/** @typedef {{ over: boolean, meters: Float64Array, strikes: Float64Array }} Answer */

const PROCESSOR = new URL("./processor.js", import.meta.url);
const KERNEL = new URL("./kernel.wasm", import.meta.url);

/**
 * Create a node that plays a memory image (browser_memory.py), or a promise of one, into `context`.
 *
 * `events` (as in `KernelNode.control`) and `changes` (bytes of `encode_change`) apply before the
 * first sample. Clicks are left and the tactor is right, unless the image's settings differ. One image
 * serves every sample rate. `wasm` holds the bytes of `kernel.wasm`; by default they are fetched from
 * this file's folder. Throws an Error if the bytes are of another version.
 * @param {BaseAudioContext} context
 * @param {ArrayBuffer | Promise<ArrayBuffer>} image
 * @param {{ events?: ControlEvent[], changes?: ArrayBuffer[], wasm?: Promise<ArrayBuffer> }} options
 */
export async function openKernel(context, image, { events = [], changes = [], wasm: wasmBytes = fetchWasm() } = {}) {
  for (const bytes of changes) checkBytes(bytes, CHANGE);
  const module = context.audioWorklet.addModule(PROCESSOR);
  const [memory, wasm] = await Promise.all([image, wasmBytes, module]);
  const { channels } = checkBytes(memory, WHOLE);
  return new KernelNode(context, channels, { wasm, image: memory, events: eventRows(events), changes });
}

async function fetchWasm() {
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
    /** @type {ControlEvent[]} */
    this.unsentEvents = [];
    /** @type {((answer: Answer) => void)[]} */
    this.pendingReads = [];
    /** Called with a message if the audio thread rejects a request. */
    this.onfault = (/** @type {string} */ message) => console.error(message);
    this.port.onmessage = ({ data }) => {
      if (data.kind === "error") this.onfault(data.message);
      else this.pendingReads.shift()?.(data);
    };
  }

  /**
   * Send one control event: theta2 in rad (0 to pi) and whether the input touches. `sampleTime`
   * counts from the node's first sample. Events of one task share one message.
   * @param {number} theta2
   * @param {boolean} touching
   */
  control(theta2, touching, source = "touch", sampleTime = AT_ONCE) {
    numberOf(source);
    this.unsentEvents.push({ sampleTime, source, theta2, touching });
    if (this.unsentEvents.length === 1) queueMicrotask(() => this.flush());
  }

  /** Send the queued events, so that later messages follow them. */
  flush(kind = "control") {
    if (this.unsentEvents.length === 0) return;
    const events = eventRows(this.unsentEvents);
    this.unsentEvents = [];
    this.port.postMessage({ kind, events }, [events.buffer]);
  }

  /**
   * Set a parameter of the preset in its own unit (`tactor.gain_db`); surface parameters need
   * `change`. A switch is 0 or 1. The value is smoothed over 20 ms.
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
   * Apply the bytes of `encode_change`: other parameters, another surface. The buffer is transferred.
   * @param {ArrayBuffer} bytes
   */
  change(bytes) {
    const { sampleRate } = checkBytes(bytes, CHANGE);
    if (sampleRate !== this.context.sampleRate) {
      throw new Error(
        `change is for ${sampleRate} Hz; must be for ${this.context.sampleRate} Hz`,
      );
    }
    this.flush();
    this.port.postMessage({ kind: "change", bytes }, [bytes]);
  }

  /**
   * Set gain and ceiling (linear) and delay (s, up to 0.1) of each signal.
   * @param {Signal} click
   * @param {Signal} tactor
   */
  output(click, tactor) {
    const signals = [click, tactor].map(({ gain = 1, ceiling = 1, delay = 0 }) => {
      if (!(gain >= 0 && gain <= 16 && ceiling > 0 && ceiling <= 1 && delay >= 0 && delay <= 0.1)) {
        throw new Error(
          `gain ${gain}, ceiling ${ceiling}, delay ${delay} s; ` +
            "must be 0 to 16, above 0 to 1, 0 to 0.1 s",
        );
      }
      return { gain, ceiling, delay: Math.round(delay * this.context.sampleRate) };
    });
    this.port.postMessage({ kind: "output", signals });
  }

  /**
   * Return the meters by name, the new strikes, and whether playback has ended.
   * @returns {Promise<KernelState>}
   */
  readState() {
    return new Promise((resolve) => {
      this.pendingReads.push(({ over, meters, strikes }) => {
        const meterValues = Object.fromEntries(METERS.map((name, i) => [name, meters[i]]));
        const state = /** @type {KernelState} */ (meterValues);
        const newStrikes = [];
        for (let i = 0; i < strikes.length; i += STRIKE_FIELDS) {
          const [sample, event, torque, level] = strikes.subarray(i, i + STRIKE_FIELDS);
          newStrikes.push({ sample, event, torque, level });
        }
        resolve({ ...state, over, newStrikes });
      });
      if (this.unsentEvents.length > 0) this.flush("read"); // one message instead of two
      else this.port.postMessage({ kind: "read" });
    });
  }

  /** Fade out and end. */
  stop() {
    this.flush();
    this.port.postMessage({ kind: "stop" });
  }
}

/** @param {string} source */
function numberOf(source) {
  const found = SOURCES.indexOf(source);
  if (found < 0) throw new Error(`unknown input ${source}; must be one of: ${SOURCES.join(", ")}`);
  return found;
}

/**
 * Return control events as rows for the audio thread.
 * @param {ControlEvent[]} events
 */
function eventRows(events) {
  const table = new Float64Array(4 * events.length);
  events.forEach(({ sampleTime = AT_ONCE, source = "touch", theta2, touching }, i) => {
    table.set([sampleTime, numberOf(source), theta2, touching ? 1 : 0], 4 * i);
  });
  return table;
}
