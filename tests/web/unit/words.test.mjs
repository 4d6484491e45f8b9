import assert from "node:assert/strict";
import { readdirSync, readFileSync } from "node:fs";
import test from "node:test";

const SITE = new URL("../../../overview_dsp/web/site/", import.meta.url);
// features of a server, and the element of an article, have their texts themselves
const OTHERS = /words\.js$|^(served|editor_.*|preset_.*|media_player|link|host_sound|embed|worker|offline|dom)\.js$/;
const CODE = /^(?:\d+px |keep windows|d[ 0-9]|.*[{}<>=;#:](?!.*\$))|sans-serif/; // fonts, messages, selectors

/** @param {string} script */
const literals = (script) => [...script.replace(/\/\*[\s\S]*?\*\/|^\s*\/\/.*$|\s\/\/ .*$/gm, "")
  .matchAll(/"([^"\n]*)"|`([^`]*)`/g)].map(([, plain, template]) => plain ?? template.replace(/\$\{[^}]*\}/g, ""));

test("scripts take the texts that a person reads from the catalogues", () => {
  const found = readdirSync(SITE).filter((name) => name.endsWith(".js") && !OTHERS.test(name)).flatMap((name) =>
    literals(readFileSync(new URL(name, SITE), "utf8"))
      .filter((text) => /[A-Za-z]{2,} [a-z]{2,}/.test(text) && !CODE.test(text))
      .map((text) => `${name}: ${text}`));
  assert.deepEqual(found, []);
});

test("each text of the catalogues is used", () => {
  const scripts = readdirSync(SITE).filter((name) => name.endsWith(".js"))
    .map((name) => [name, readFileSync(new URL(name, SITE), "utf8")]);
  for (const [file, words] of scripts.filter(([name]) => name.endsWith("words.js"))) {
    for (const [, name] of words.matchAll(/^export const (\w+)/gm)) {
      const uses = scripts.filter(([, script]) => new RegExp(`\\b${name}\\b[^;]*from "./${file}"`).test(script));
      assert.ok(uses.length > 0 || words.split(new RegExp(`\\b${name}\\b`)).length > 2, `${file}: ${name}`);
    }
  }
});
