// What is felt and heard of a stimulus: its files, an audio node of its own for each presentation,
// channels with their gains, masking noise.

import { patched } from "./data.js";
import { SOURCES } from "./layout.js";
import { pause } from "./make.js";

const FADED_MS = 200;
const LOOK_MS = 30;
const RELEASED_MS = 500; // far more than a hand's events lie ahead
const RATES = [48_000, 44_100]; // what the folder has
const MOST_FILES = 96; // in memory, half a megabyte each
const LONGEST_REST_S = 3;
const START_MS = 5000;
const SILENT = "no sound starts: check that this device has a sound output, then try again";

/** Round half to even, as Python does. */
export function rounded(number) {
  const low = Math.floor(number);
  if (number - low !== 0.5) return Math.round(number);
  return low % 2 === 0 ? low : low + 1;
}

/** A stimulus' control events as the audio thread takes them. */
export function rowsOf(events, rate) {
  return Float64Array.from(events.flatMap(({ time_s, theta2, touching, source = "touch" }) =>
    [rounded(time_s * rate), SOURCES.indexOf(source), theta2, touching ? 1 : 0]));
}

export class Felt {
  /** `file(path)` fetches one of `study`'s. Silent until `start` is called in a click or a key. */
  constructor(study, file) {
    this.study = study;
    this.file = file;
    const { audioSession } = /** @type {any} */ (navigator);
    if (audioSession) audioSession.type = "playback"; // iPhones: heard in spite of the silent switch
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

  /** Sound from now on; an Error in one line where none comes. */
  async start() {
    if (this.context.state === "running") return;
    const silent = new Promise((_, reject) => {
      setTimeout(() => reject(new Error(SILENT)), START_MS);
    });
    await Promise.race([this.context.resume(), silent]);
  }

  /** What a row says of the device. */
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

  /** Fetch what a trial needs, so that it begins without a wait. */
  async load({ stimuli, output }) {
    this.worklet ??= this.context.audioWorklet.addModule(new URL("./felt_processor.js", import.meta.url));
    await Promise.all([
      this.worklet,
      output.mapping === "static" ? null : this.wasm(),
      output.mask ? this.noise() : null,
      ...stimuli.map((key) => this.memory(key, output)),
      ...(output.visual ? stimuli.map((key) => this.drawn(key)) : []),
    ]);
  }

  /** What is drawn of a stimulus. */
  drawn(key) {
    return this.kept(this.study.stimuli[key].drawn, (answer) => answer.json());
  }

  /** A stimulus at the beginning of a presentation; `events`: of the person's own hand, if null. */
  async open(key, output, events = this.study.stimuli[key].events) {
    await this.load({ stimuli: [key], output });
    const memory = await this.memory(key, output);
    const wasm = output.mapping === "static" ? null : await this.wasm();
    const given = events === null ? new Float64Array(0) : rowsOf(events, this.rate);
    const heard = output.mapping === "static" ? { mapping: memory } : { image: memory, wasm };
    return new Presentation(this.context, { ...heard, events: given }, output);
  }

  /** Masking noise for the ears, from now on or no more. */
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
    source.connect(merge, 0, 0).connect(context.destination); // to the clicks' channel alone
    source.start();
  }

  noise() {
    const { mask } = this.study;
    return this.kept(mask.file, async (answer) =>
      this.context.decodeAudioData(await answer.arrayBuffer()));
  }

  wasm() {
    return this.kept("kernel.wasm", (answer) => answer.arrayBuffer());
  }

  memory(key, output) {
    const { image, patches, static: mapped } = this.study.stimuli[key];
    if (output.mapping === "static") {
      return this.kept(mapped[this.rate], (answer) => answer.json());
    }
    const whole = this.kept(image, (answer) => answer.arrayBuffer());
    if (this.rate === RATES[0]) return whole;
    const patch = this.kept(patches[this.rate], (answer) => answer.arrayBuffer());
    return Promise.all([whole, patch]).then(([base, other]) => patched(base, other));
  }

  kept(path, take) {
    if (!this.files.has(path)) {
      if (this.files.size >= MOST_FILES) this.files.delete(this.files.keys().next().value);
      const taken = this.file(path).then(take);
      taken.catch(() => this.files.delete(path)); // tried again the next time
      this.files.set(path, taken);
    }
    return this.files.get(path);
  }
}

const linear = (db) => (db === null ? 0 : 10 ** (db / 20));

/** One presentation: its node from its first sample to its last, and the take of the hand. */
export class Presentation {
  constructor(context, options, { click_db, tactor_db }) {
    this.rate = context.sampleRate;
    this.node = new AudioWorkletNode(context, "overview-felt", {
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
    this.events = []; // of the take
    this.told = { clock: 0, cursor: 0, rests: true };
    this.asked = [];
    /** Called with a line when the audio thread fails. */
    this.onfault = /** @type {(line: string) => void} */ (() => {});
    this.node.port.onmessage = ({ data }) => {
      if (data.error) this.onfault(data.error);
      else this.asked.shift()(data);
    };
    this.node.onprocessorerror = () => this.onfault("the sound has failed: load the page again");
  }

  /** A hand's event at a sample (-1: at once). */
  control(place, touching, sample) {
    const events = Float64Array.of(sample, 0, place * Math.PI, touching ? 1 : 0);
    this.node.port.postMessage({ kind: "control", events });
  }

  /** How it is now; what was applied since goes into the take. */
  look() {
    return new Promise((resolve) => {
      this.asked.push(({ meters: [clock, cursor, rests], applied }) => {
        for (let i = 0; i + 4 <= applied.length; i += 4) {
          const [sample, theta2, touching, source] = applied.subarray(i, i + 4);
          this.events.push([sample, theta2, touching, SOURCES[source]]);
        }
        this.told = { clock, cursor, rests };
        resolve(this.told);
      });
      this.node.port.postMessage({ kind: "look" });
    });
  }

  /** When so many seconds were played and it rests, `onlook` told meanwhile; false where it was stopped. */
  async rested(duration_s, onlook = /** @type {(told: any) => void} */ (() => {})) {
    const least = duration_s * this.rate;
    const most = least + LONGEST_REST_S * this.rate;
    while (!this.stopped) {
      const { clock, rests } = await this.look();
      onlook(this.told);
      if (clock >= most || (clock >= least && rests)) return true;
      await pause(LOOK_MS);
    }
    return false;
  }

  /** The take, once the hand has let go: what was asked of the audio thread last may still be to come. */
  async take() {
    const until = performance.now() + RELEASED_MS;
    do await this.look();
    while (this.events.at(-1)?.[2] === 1 && performance.now() < until);
    return { sample_rate: this.rate, samples: this.told.clock, events: [...this.events] };
  }

  /** Fade out and end. */
  stop() {
    if (this.stopped) return;
    this.stopped = true;
    this.node.port.postMessage({ kind: "stop" });
    setTimeout(() => this.end.disconnect(), FADED_MS);
  }
}
