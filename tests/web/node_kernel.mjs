// Plays an image in node: node_kernel.mjs PACKAGE FOLDER ASKED. The folder has `image` and gets `out`
// (float32, frame after frame) and `memory`.
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";

const [web, folder, asked] = process.argv.slice(2);
const { Kernel, parameterNumber } = await import(join(web, "kernel.js"));
const { rate, settings, block, blocks } = JSON.parse(asked);
const bytes = (path) => new Uint8Array(readFileSync(path)).buffer;

const kernel = new Kernel(bytes(join(web, "kernel.wasm")), bytes(join(folder, "image")), rate);
kernel.control([100, 0, 2, 1]);
for (const [id, value, at] of settings) kernel.set(parameterNumber(id, value), value, at);
const outputs = [new Float32Array(block), new Float32Array(block)];
const out = new Float32Array(2 * block * blocks);
for (let n = 0; n < blocks; n += 1) {
  kernel.render(outputs);
  outputs.forEach((channel, at) => channel.forEach((value, i) => {
    out[2 * (n * block + i) + at] = value;
  }));
}
writeFileSync(join(folder, "out"), out);
writeFileSync(join(folder, "memory"), kernel.words);
