// AudioWorklet of a trial: the kernel or the control condition, and the take of the applied events.

import { Kernel } from "./kernel.js";
import { L } from "./layout.js";
import { StaticMapping } from "./static_mapping.js";

const EVENT = 4; // sample, theta2, touching, source
const REST_THRESHOLD = 1e-4; // of the timeline, of full amplitude

/** Kernel with its log of applied control events. */
class KernelSource {
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

  /** Overwrite a block; return whether the sound has ended. */
  render(outputs) {
    return this.kernel.render(outputs);
  }

  /** Return the events applied since the last call, EVENT numbers per event. */
  applied() {
    const { kernel } = this;
    const total = kernel.read(L.APPLIED);
    if (total - this.read > L.APPLIED_LOG) throw new Error("input events exceed the log capacity");
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

  /** Return clock (samples), cursor (0 to 1) and whether the disk rests. */
  meters() {
    const { kernel } = this;
    const cursor = kernel.numbers[L.X] / L.CELLS;
    const rests = cursor < REST_THRESHOLD && kernel.numbers[L.M_ENVELOPE] < REST_THRESHOLD;
    return [kernel.read(L.CLOCK), cursor, rests];
  }
}

class StaticSource {
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
    return [clock, cursor, level < REST_THRESHOLD && voices === 0];
  }
}

class StimulusProcessor extends AudioWorkletProcessor {
  constructor({ processorOptions: { wasm, image, mapping, events } }) {
    super();
    this.source = mapping ? new StaticSource(mapping) : new KernelSource(wasm, image);
    this.source.control(events);
    this.port.onmessage = ({ data }) => {
      try {
        this.handle(data);
      } catch (error) {
        this.port.postMessage({ error: error.message });
      }
    };
  }

  handle({ kind, events }) {
    if (kind === "control") this.source.control(events);
    else if (kind === "stop") this.source.stop();
    else {
      const applied = this.source.applied();
      this.port.postMessage({ meters: this.source.meters(), applied }, [applied.buffer]);
    }
  }

  process(inputs, outputs) {
    return !this.source.render(outputs[0]);
  }
}

registerProcessor("overview-stimulus", StimulusProcessor);
