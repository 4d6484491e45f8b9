// The page's sound: an audio context with the kernel in it, and where its two signals go.
// `host_sound.js` has the same face.

import { SampleClock } from "./clock.js";
import { openKernel } from "./kernel_node.js";

const GLIDE_S = 0.02;

// of each way to feel: how much of click and tactor goes to left and right
const ROUTES = {
  tactor: { click: [1, 0], tactor: [0, 1] },
  motor: { click: [1, 1], tactor: [0, 0] },
  ears: { click: [1, 1], tactor: [0.5, 0.5] },
};

export class Sound {
  /** Open it, silent until `start`; the memory is fetched by `data`. */
  static async open(data) {
    const sound = new Sound();
    sound.data = data;
    // iPhones: as music, so that the silent switch doesn't still it
    if (navigator.audioSession) navigator.audioSession.type = "playback";
    const { rates } = data.info;
    let context = new AudioContext({ latencyHint: "interactive" });
    if (!rates.includes(context.sampleRate)) {
      await context.close();
      context = new AudioContext({ latencyHint: "interactive", sampleRate: rates[0] });
    }
    sound.context = context;
    sound.clock = new SampleClock(context.sampleRate);
    sound.node = await openKernel(context, await data.memory(context.sampleRate));
    sound.wire();
    return sound;
  }

  wire() {
    const { context, node } = this;
    const split = context.createChannelSplitter(2);
    const merge = context.createChannelMerger(2);
    node.connect(split);
    this.gains = { click: [], tactor: [] };
    Object.values(this.gains).forEach((signal, from) => {
      for (const to of [0, 1]) {
        const gain = context.createGain();
        split.connect(gain, from).connect(merge, 0, to);
        signal.push(gain);
      }
    });
    this.route("tactor", true);
    merge.connect(context.destination);
    this.end = merge;
  }

  /** In a touch or a key: only then a browser lets a page sound. */
  start() {
    if (this.context.state !== "running") this.context.resume();
  }

  get running() {
    return this.context.state === "running";
  }

  control(place, touching, sample) {
    this.node.control(place * Math.PI, touching, "touch", sample);
  }

  /** Where the signals go: tactor, motor or ears. */
  route(felt, atOnce = false) {
    for (const [signal, levels] of Object.entries(ROUTES[felt])) {
      levels.forEach((level, side) => {
        const { gain } = this.gains[signal][side];
        if (atOnce) gain.value = level;
        else gain.setTargetAtTime(level, this.context.currentTime, GLIDE_S);
      });
    }
  }

  /** Gains of both, linear. */
  volume(click, tactor) {
    this.node.output({ gain: click }, { gain: tactor });
  }

  /** Fetch what it takes to put a part under the hand; call the answer to do so. */
  async show(part) {
    const bytes = await this.data.change(part, this.context.sampleRate);
    return () => this.node.change(bytes);
  }

  /** Go from one preset to another; `part` has the surface, null if it stays. */
  async feel(before, after, part) {
    this.node.change(await this.data.feel(before, after, part, this.context.sampleRate));
  }

  /** The kernel's meters and strikes. */
  async look() {
    const told = await this.node.look();
    this.clock.heard(told.clock, performance.now());
    return told;
  }
}
