// The AudioWorklet: the kernel, a render quantum at a time; left is clicks, right is the tactor.
//
// Everything but sound comes by messages, which the browser hands over between two quanta: a few
// numbers a gesture event, and what the page wants to draw only when it asks. A ring in a
// SharedArrayBuffer would save the browser that copy, but needs two headers (COOP, COEP) that
// many static hosts can't send, and the page must sound the same from all of them. Audio is never
// posted, and `process` creates no object.

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
        this.take(data);
      } catch (error) {
        this.port.postMessage({ kind: "error", message: error.message });
      }
    };
  }

  take(data) {
    const { kernel } = this;
    if (data.kind === "control") kernel.control(data.events);
    else if (data.kind === "change") kernel.change(data.bytes);
    else if (data.kind === "set") kernel.set(data.number, data.value, data.sampleTime);
    else if (data.kind === "output") kernel.output(data.signals);
    else if (data.kind === "stop") kernel.stop();
    else if (data.kind === "look") {
      const meters = kernel.meters();
      const strikes = kernel.strikes();
      this.port.postMessage(
        { kind: "look", over: this.over, meters, strikes },
        [meters.buffer, strikes.buffer],
      );
    } else throw new Error(`no message is called ${data.kind}`);
  }

  process(inputs, outputs) {
    this.over = this.kernel.render(outputs[0]);
    return !this.over;
  }
}

registerProcessor("overview-kernel", OverviewProcessor);
