import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import test from "node:test";

/** @param {string} name */
const textOf = (name) => readFileSync(new URL(`../../../overview_dsp/web/${name}`, import.meta.url), "utf8");

const TYPES = {
  a: "HTMLAnchorElement", button: "HTMLButtonElement", canvas: "HTMLCanvasElement", dialog: "HTMLDialogElement",
  form: "HTMLFormElement", input: "HTMLInputElement", select: "HTMLSelectElement", svg: "SVGSVGElement",
  video: "HTMLVideoElement",
};

test("the types list each id of the page, with the type of its element", () => {
  const types = textOf("types.d.ts");
  const quoted = (text) => [...text.matchAll(/"([\w-]+)"/g)].map(([, id]) => id);
  const lists = Object.fromEntries(
    [...types.matchAll(/^type (\w+) = ([^;]+);/gm)].map(([, name, ids]) => [name, quoted(ids)]));
  const [, elements] = types.split("export interface Elements");
  const declared = [...elements.matchAll(/Record<([^,]+), (\w+)>/g)]
    .flatMap(([, ids, type]) => (lists[ids] ?? quoted(ids)).map((id) => [id, type]));
  declared.push(...[...elements.matchAll(/^ {2}"?([\w-]+)"?: (\w+);/gm)].map(([, id, type]) => [id, type]));
  const found = [...textOf("site/index.html").matchAll(/<(\w+)[^>]*? id="([^"]+)"/g)]
    .map(([, tag, id]) => [id, TYPES[tag] ?? "HTMLElement"]);
  assert.ok(found.length > 80);
  assert.deepEqual(declared.sort(), found.sort());
});
