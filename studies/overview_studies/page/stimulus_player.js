// Playback of stimuli: files, one audio node per presentation, channel gains and masking noise.

import { patched } from "./data.js";
import { SOURCES } from "./layout.js";
import { pause } from "./make.js";

const FADED_MS = 200;
const POLL_MS = 30;
const PENDING_TIMEOUT_MS = 5000; // the first sound of a page may take longer than a short gesture
const RATES = [48_000, 44_100]; // rates in the folder
const MAX_FILES = 96; // in memory, half a megabyte each
const MAX_REST_S = 3;
const HELD_REST_S = 0.5; // after a gesture without a release, the disk stays away from its rest
const START_MS = 5000;
const SILENT = "the audio output does not start; check the output of this device, then try again";

/** Round half to even, as Python does. */
export function rounded(number) {
  const low = Math.floor(number);
  if (number - low !== 0.5) return Math.round(number);
  return low % 2 === 0 ? low : low + 1;
}

/** Return a stimulus's control events in the format of the audio thread. */
export function rowsOf(events, rate) {
  return Float64Array.from(events.flatMap(({ time_s, theta2, touching, source = "touch" }) =>
    [rounded(time_s * rate), SOURCES.indexOf(source), theta2, touching ? 1 : 0]));
}

export class StimulusPlayer {
  /** `file(path)` fetches a file of `study`. Audio starts when a click or key handler calls `start`. */
  constructor(study, file) {
    this.study = study;
    this.file = file;
    const { audioSession } = /** @type {any} */ (navigator);
    if (audioSession) audioSession.type = "playback"; // iPhones: audible despite the silent switch
    this.context = new AudioContext({ latencyHint: "interactive" });
    if (!RATES.includes(this.context.sampleRate)) {
      this.context.close();
      this.context = new AudioContext({ latencyHint: "interactive", sampleRate: RATES[0] });
    }
    this.worklet = null; // a promise, once it loads
    this.files = new Map(); // promises by path
    this.masking = null;
  }

  get rate() {
    return this.context.sampleRate;
  }

  /** Start audio; throws an Error with one line on failure. */
  async start() {
    if (this.context.state === "running") return;
    const silent = new Promise((_, reject) => {
      setTimeout(() => reject(new Error(SILENT)), START_MS);
    });
    await Promise.race([this.context.resume(), silent]);
  }

  /** Device data for a row. */
  get device() {
    const { context } = this;
    return {
      user_agent: navigator.userAgent,
      sample_rate: context.sampleRate,
      base_latency_ms: 1e3 * (context.baseLatency ?? 0),
      output_latency_ms: 1e3 * (context.outputLatency ?? 0),
      width: window.innerWidth,
      height: window.innerHeight,
      touch: navigator.maxTouchPoints > 0,
    };
  }

  /** Load the files of a trial. */
  async load({ stimuli, output }) {
    this.worklet ??= this.context.audioWorklet.addModule(new URL("./stimulus_processor.js", import.meta.url));
    await Promise.all([
      this.worklet,
      output.mapping === "static" ? null : this.wasm(),
      output.mask ? this.noise() : null,
      ...stimuli.map((key) => this.memory(key, output)),
      ...(output.visual ? stimuli.map((key) => this.drawn(key)) : []),
    ]);
  }

  /** Return the drawing data of a stimulus. */
  drawn(key) {
    return this.cached(this.study.stimuli[key].drawn, (answer) => answer.json());
  }

  /** Start a presentation of a stimulus; `events` is null for free exploration. */
  async open(key, output, events = this.study.stimuli[key].events) {
    await this.load({ stimuli: [key], output });
    const memory = await this.memory(key, output);
    const wasm = output.mapping === "static" ? null : await this.wasm();
    const rows = events === null ? new Float64Array(0) : rowsOf(events, this.rate);
    const source = output.mapping === "static" ? { mapping: memory } : { image: memory, wasm };
    const presentation = new Presentation(this.context, { ...source, events: rows }, output);
    if (events?.at(-1)?.touching) presentation.longestRest_s = HELD_REST_S;
    return presentation;
  }

  /** Switch the masking noise on or off. */
  async mask(on) {
    this.masking?.stop();
    this.masking = null;
    if (!on) return;
    const { context } = this;
    const source = context.createBufferSource();
    this.masking = source;
    source.buffer = await this.noise();
    source.loop = true;
    const merge = context.createChannelMerger(2);
    source.connect(merge, 0, 0).connect(context.destination); // to the click channel only
    source.start();
  }

  noise() {
    const { mask } = this.study;
    return this.cached(mask.file, async (answer) =>
      this.context.decodeAudioData(await answer.arrayBuffer()));
  }

  wasm() {
    return this.cached("kernel.wasm", (answer) => answer.arrayBuffer());
  }

  memory(key, output) {
    const { image, patches, static: mapped } = this.study.stimuli[key];
    if (output.mapping === "static") {
      return this.cached(mapped[this.rate], (answer) => answer.json());
    }
    const whole = this.cached(image, (answer) => answer.arrayBuffer());
    if (this.rate === RATES[0]) return whole;
    const patch = this.cached(patches[this.rate], (answer) => answer.arrayBuffer());
    return Promise.all([whole, patch]).then(([base, other]) => patched(base, other));
  }

  cached(path, parse) {
    if (!this.files.has(path)) {
      if (this.files.size >= MAX_FILES) this.files.delete(this.files.keys().next().value);
      const loaded = this.file(path).then(parse);
      loaded.catch(() => this.files.delete(path)); // retried at the next call
      this.files.set(path, loaded);
    }
    return this.files.get(path);
  }
}

const linear = (db) => (db === null ? 0 : 10 ** (db / 20));

/** One presentation: its audio node and the take of the input. */
export class Presentation {
  constructor(context, options, { click_db, tactor_db }) {
    this.rate = context.sampleRate;
    this.node = new AudioWorkletNode(context, "overview-stimulus", {
      numberOfInputs: 0, outputChannelCount: [2], processorOptions: options,
    });
    const split = context.createChannelSplitter(2);
    const merge = context.createChannelMerger(2);
    this.node.connect(split);
    [click_db, tactor_db].forEach((db, channel) => {
      const gain = context.createGain();
      gain.gain.value = linear(db);
      split.connect(gain, channel).connect(merge, 0, channel);
    });
    merge.connect(context.destination);
    this.end = merge;
    this.events = []; // events of the take
    this.sent = 0; // input events sent to the audio thread
    this.state = { clock: 0, cursor: 0, rests: true };
    this.pendingReads = [];
    this.longestRest_s = MAX_REST_S;
    /** Called with a message when the audio thread fails. */
    this.onfault = /** @type {(line: string) => void} */ (() => {});
    this.node.port.onmessage = ({ data }) => {
      if (data.error) this.onfault(data.error);
      else this.pendingReads.shift()(data);
    };
    this.node.onprocessorerror = () => this.onfault("audio processing failed; reload the page");
  }

  /** Send an input event at a sample (-1: immediately). */
  control(place, touching, sample) {
    const events = Float64Array.of(sample, 0, place * Math.PI, touching ? 1 : 0);
    this.node.port.postMessage({ kind: "control", events });
    this.sent += 1;
  }

  /** Read the current state; events applied since the last call are added to the take. */
  readState() {
    return new Promise((resolve) => {
      this.pendingReads.push(({ meters: [clock, cursor, rests], applied }) => {
        for (let i = 0; i + 4 <= applied.length; i += 4) {
          const [sample, theta2, touching, source] = applied.subarray(i, i + 4);
          this.events.push([sample, theta2, touching, SOURCES[source]]);
        }
        this.state = { clock, cursor, rests };
        resolve(this.state);
      });
      this.node.port.postMessage({ kind: "read state" });
    });
  }

  /** Wait for `duration_s` and for rest, with calls of `onstate`; resolves to false if stopped. */
  async rested(duration_s, onstate = /** @type {(state: any) => void} */ (() => {})) {
    const least = duration_s * this.rate;
    const most = least + this.longestRest_s * this.rate;
    while (!this.stopped) {
      const { clock, rests } = await this.readState();
      onstate(this.state);
      if (clock >= most || (clock >= least && rests)) return true;
      await pause(POLL_MS);
    }
    return false;
  }

  /** Return the take after the release, once the audio thread has applied each event that was sent. */
  async take() {
    const until = performance.now() + PENDING_TIMEOUT_MS;
    while (await this.readState(), this.events.length < this.sent && performance.now() < until) {
      await pause(POLL_MS);
    }
    const pending = this.sent - this.events.length;
    const take = { sample_rate: this.rate, samples: this.state.clock, events: [...this.events] };
    return pending > 0 ? { ...take, pending } : take;
  }

  /** Fade out and end. */
  stop() {
    if (this.stopped) return;
    this.stopped = true;
    this.node.port.postMessage({ kind: "stop" });
    setTimeout(() => this.end.disconnect(), FADED_MS);
  }
}
