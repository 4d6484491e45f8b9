// The AudioWorklet of a trial: the kernel or the control condition, with the take of what the hand
// did as it was applied.

import { Kernel } from "./kernel.js";
import { L } from "./layout.js";
import { StaticMapping } from "./static_mapping.js";

const EVENT = 4; // sample, theta2, touching, source
const STILL = 1e-4; // of the timeline, of full amplitude

/** The kernel, and the log of the control events that it has applied. */
class Disk {
  constructor(wasm, image) {
    this.kernel = new Kernel(wasm, image);
    this.read = 0;
  }

  control(events) {
    this.kernel.control(events);
  }

  stop() {
    this.kernel.stop();
  }

  /** Overwrite a block; whether the sound is over. */
  render(outputs) {
    return this.kernel.render(outputs);
  }

  /** The events applied since the last call, EVENT numbers each. */
  applied() {
    const { kernel } = this;
    const total = kernel.read(L.APPLIED);
    if (total - this.read > L.APPLIED_LOG) throw new Error("a hand's events came too fast to keep");
    const rows = new Float64Array(EVENT * (total - this.read));
    for (let i = this.read; i < total; i += 1) {
      const at = i % L.APPLIED_LOG;
      rows.set(
        [kernel.read(L.APPLIED_TIME + at), kernel.numbers[L.APPLIED_THETA2 + at],
          kernel.read(L.APPLIED_TOUCHING + at), kernel.read(L.APPLIED_SOURCE + at)],
        EVENT * (i - this.read),
      );
    }
    this.read = total;
    return rows;
  }

  /** Clock (samples), cursor (0 to 1), whether it rests. */
  meters() {
    const { kernel } = this;
    const cursor = kernel.numbers[L.X] / L.CELLS;
    const rests = cursor < STILL && kernel.numbers[L.M_ENVELOPE] < STILL;
    return [kernel.read(L.CLOCK), cursor, rests];
  }
}

class Mapped {
  constructor(data) {
    this.mapping = new StaticMapping(data);
    this.over = false;
  }

  control(events) {
    this.mapping.control(events);
  }

  stop() {
    this.over = true;
  }

  render(outputs) {
    if (!this.over) this.mapping.render(outputs[0], outputs[1]);
    return this.over;
  }

  applied() {
    return Float64Array.from(this.mapping.applied.splice(0).flat());
  }

  meters() {
    const { clock, cursor, level, voices } = this.mapping;
    return [clock, cursor, level < STILL && voices === 0];
  }
}

class FeltProcessor extends AudioWorkletProcessor {
  constructor({ processorOptions: { wasm, image, mapping, events } }) {
    super();
    this.felt = mapping ? new Mapped(mapping) : new Disk(wasm, image);
    this.felt.control(events);
    this.port.onmessage = ({ data }) => {
      try {
        this.take(data);
      } catch (error) {
        this.port.postMessage({ error: error.message });
      }
    };
  }

  take({ kind, events }) {
    if (kind === "control") this.felt.control(events);
    else if (kind === "stop") this.felt.stop();
    else {
      const applied = this.felt.applied();
      this.port.postMessage({ meters: this.felt.meters(), applied }, [applied.buffer]);
    }
  }

  process(inputs, outputs) {
    return !this.felt.render(outputs[0]);
  }
}

registerProcessor("overview-felt", FeltProcessor);
