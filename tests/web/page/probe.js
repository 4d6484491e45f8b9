// What the browser tests run in the page.

import { Kernel } from "/kernel.js";
import { openKernel } from "/kernel_node.js";

const QUANTUM = 128;

async function bytes(name) {
  const answer = await fetch(`/given/${name}`);
  if (!answer.ok) throw new Error(`${name}: ${answer.status}`);
  return answer.arrayBuffer();
}

function all(names) {
  return Promise.all(names.map(bytes));
}

function base64(view) {
  const octets = new Uint8Array(view.buffer, view.byteOffset, view.byteLength);
  let text = "";
  for (let i = 0; i < octets.length; i += 32768) {
    text += String.fromCharCode(...octets.subarray(i, i + 32768));
  }
  return btoa(text);
}

async function digest(view) {
  const sum = await crypto.subtle.digest("SHA-256", view.slice());
  return Array.from(new Uint8Array(sum), (octet) => octet.toString(16).padStart(2, "0")).join("");
}

/** Interleaved float32 samples of an AudioBuffer. */
function interleaved(buffer) {
  const count = buffer.numberOfChannels;
  const samples = new Float32Array(count * buffer.length);
  for (let channel = 0; channel < count; channel += 1) {
    buffer.getChannelData(channel).forEach((sample, i) => {
      samples[count * i + channel] = sample;
    });
  }
  return samples;
}

/**
 * An offline rendering. `events` and `changes` come before the first sample; `sends` are
 * [sample, method, arguments], sent to the running node at the next render quantum, where an
 * argument { given: name } stands for bytes. At the sample `foul`, messages that make no sense.
 */
export async function renderOffline({
  rate, frames, image, events = [], changes = [], sends = [], foul, channels = 2,
}) {
  const context = new OfflineAudioContext(channels, frames, rate);
  if (channels > 2) context.destination.channelInterpretation = "discrete";
  const node = await openKernel(context, await bytes(image), {
    events,
    changes: await all(changes),
  });
  const faults = [];
  node.onfault = (message) => faults.push(message);
  node.onprocessorerror = (event) => faults.push(event.message ?? "processor error");
  node.connect(context.destination);
  const loaded = await Promise.all(
    sends.map(async ([sample, method, given]) => [
      sample,
      method,
      await Promise.all(given.map((one) => (one?.given ? bytes(one.given) : one))),
    ]),
  );
  const times = [...new Set(loaded.map(([sample]) => Math.ceil(sample / QUANTUM) * QUANTUM))];
  for (const time of times) {
    context.suspend(time / rate).then(async () => {
      for (const [sample, method, given] of loaded) {
        if (Math.ceil(sample / QUANTUM) * QUANTUM === time) node[method](...given);
      }
      await node.readState(); // answered after all of them
      context.resume();
    });
  }
  if (foul) {
    context.suspend(foul / rate).then(async () => {
      node.port.postMessage({ kind: "control", events: Float64Array.of(-1, 99, 1, 1) });
      node.port.postMessage({ kind: "change", bytes: new ArrayBuffer(3) });
      await node.readState();
      context.resume();
    });
  }
  const began = performance.now();
  const samples = interleaved(await context.startRendering());
  const seconds = (performance.now() - began) / 1e3;
  return { samples: base64(samples), seconds, look: await node.readState(), faults };
}

/**
 * The kernel without an audio thread, a block at a time: the digest of its memory once loaded, then
 * of the columns `region` after the blocks, and in how many of them a change still waited.
 */
export async function runKernel({ image, blocks = 0, changes = [], region = [0, 0] }) {
  const kernel = new Kernel(await bytes("kernel.wasm"), await bytes(image));
  const loaded = await digest(kernel.words);
  const outputs = [new Float32Array(QUANTUM), new Float32Array(QUANTUM)];
  for (const change of await all(changes)) kernel.change(change);
  let waited = 0;
  for (let i = 0; i < blocks; i += 1) {
    kernel.render(outputs);
    waited += kernel.waiting.length > 0 ? 1 : 0;
  }
  return { loaded, region: await digest(kernel.numbers.subarray(...region)), waited };
}

/** Bytes by which the heap grows in `blocks` blocks of a session, and microseconds a block. */
export async function heapGrowth({ image, blocks, change }) {
  const kernel = new Kernel(await bytes("kernel.wasm"), await bytes(image));
  const outputs = [new Float32Array(QUANTUM), new Float32Array(QUANTUM)];
  const rows = Float64Array.of(-1, 0, 1, 1);
  const surface = await bytes(change);
  const play = () => {
    const began = performance.now();
    for (let i = 0; i < blocks; i += 1) {
      rows[2] = 1.5 + 1.4 * Math.sin(i / 200);
      if (i % 4 === 0) kernel.control(rows);
      kernel.render(outputs);
    }
    return performance.now() - began;
  };
  for (let i = 0; i < 4; i += 1) {
    kernel.change(surface);
    play(); // until it is compiled
  }
  let grown = 0;
  let taken = Infinity;
  // a collection may hide what one round took
  for (let i = 0; i < 4; i += 1) {
    const before = performance.memory.usedJSHeapSize;
    taken = Math.min(taken, play());
    grown = Math.max(grown, performance.memory.usedJSHeapSize - before);
  }
  return { grown, microseconds: (1e3 * taken) / blocks, waiting: kernel.waiting.length };
}

/** What a node in a real-time context tells at two looks, a moment and a touch apart. */
export async function playInTime(image, rate, milliseconds) {
  const context = new AudioContext({ sampleRate: rate });
  const node = await openKernel(context, await bytes(image));
  const faults = [];
  node.onfault = (message) => faults.push(message);
  node.onprocessorerror = (event) => faults.push(event.message ?? "processor error");
  node.connect(context.destination);
  const moment = () => new Promise((resolve) => setTimeout(resolve, milliseconds));
  await moment();
  const first = await node.readState();
  node.control(2.0, true);
  await moment();
  const second = await node.readState();
  node.stop();
  await moment();
  const last = await node.readState();
  await context.close();
  return { state: context.state, faults, first, second, last };
}

/** The line with which damaged bytes are refused. */
export async function refusal(image, change) {
  try {
    const kernel = new Kernel(await bytes("kernel.wasm"), await bytes(image));
    kernel.change(await bytes(change));
  } catch (error) {
    return error.message;
  }
  return "";
}
