// The AudioWorklet processor: it renders the kernel; left is the clicks, right is the tactor.
//
// All control data arrive as messages, which the browser delivers between two render quanta. A ring
// in a SharedArrayBuffer would avoid copies, but it needs two headers (COOP, COEP) that many static
// hosts can't send. No audio is posted, and `process` creates no object.

import { Kernel } from "./kernel.js";

class OverviewProcessor extends AudioWorkletProcessor {
  constructor({ processorOptions: { wasm, image, events, changes } }) {
    super();
    this.kernel = new Kernel(wasm, image, sampleRate);
    this.over = false;
    for (const bytes of changes) this.kernel.change(bytes);
    this.kernel.takeChanges(Infinity);
    this.kernel.control(events);
    this.port.onmessage = ({ data }) => {
      try {
        this.onMessage(data);
      } catch (error) {
        this.port.postMessage({ kind: "error", message: error.message });
      }
    };
  }

  onMessage(data) {
    const { kernel } = this;
    if (data.kind === "control") kernel.control(data.events);
    else if (data.kind === "change") kernel.change(data.bytes);
    else if (data.kind === "set") kernel.set(data.number, data.value, data.sampleTime);
    else if (data.kind === "output") kernel.output(data.signals);
    else if (data.kind === "stop") kernel.stop();
    else if (data.kind === "read") {
      if (data.events) kernel.control(data.events);
      const meters = kernel.meters();
      const strikes = kernel.strikes();
      this.port.postMessage(
        { kind: "read", over: this.over, meters, strikes },
        [meters.buffer, strikes.buffer],
      );
    } else throw new Error(`unknown message ${data.kind}`);
  }

  process(inputs, outputs) {
    this.over = this.kernel.render(outputs[0]);
    return !this.over;
  }
}

registerProcessor("overview-kernel", OverviewProcessor);
