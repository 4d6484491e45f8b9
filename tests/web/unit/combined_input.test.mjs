import assert from "node:assert/strict";
import test from "node:test";
import { CombinedInput } from "../../../overview_dsp/web/site/combined_input.js";

/** Return an input and a list of what the disk receives: positions, and "release". */
function opened() {
  const sent = [];
  const input = new CombinedInput({
    touch: (position) => sent.push(position),
    move: (position) => sent.push(position),
    release: () => sent.push("release"),
  });
  return { input, sent };
}

test("a single source is followed exactly, within the timeline", () => {
  const { input, sent } = opened();
  for (const position of [1.2, 0.5, 1.4, -3, 0.1]) input.moveTo("touch", position);
  input.release("touch");
  assert.deepEqual(sent, [1, 0.5, 1, 0, 0.1, "release"]);
  assert.equal(input.position, 0.1);
});

test("a source that takes over continues from the old position", () => {
  for (const [old, next] of [[0.2, 0.9], [0.9, 0.2], [0, 1], [0.5, 0.5]]) {
    const { input, sent } = opened();
    input.moveTo("touch", old);
    input.moveTo("twist", next);
    assert.deepEqual([sent, input.active, input.position], [[old], "twist", old]);
    for (let i = 1, before = next; i <= 400; i += 1) {
      const target = Math.min(Math.max(next + 0.4 * Math.sin(i / 9), 0), 1);
      input.moveTo("twist", target);
      const moved = Math.abs(target - before);
      assert.ok(Math.abs(sent.at(-1) - sent.at(-2)) <= 1.5 * moved + 1e-12, "a jump");
      assert.ok(Math.abs(target - sent.at(-1)) <= Math.abs(old - next) + 1e-12, "away from the source");
      before = target;
    }
    assert.equal(sent.at(-1), input.positions.twist);
  }
});

test("a source that holds still does not close its gap", () => {
  const { input } = opened();
  input.moveTo("touch", 0.2);
  input.moveTo("twist", 0.9);
  for (let i = 0; i < 50; i += 1) input.moveTo("twist", 0.9);
  assert.ok(Math.abs(input.position - 0.2) < 1e-12);
});

test("an older source neither moves the disk nor takes over again", () => {
  const { input, sent } = opened();
  input.moveTo("twist", 0.2);
  input.moveTo("touch", 0.2);
  input.moveTo("twist", 0.8);
  assert.deepEqual([sent, input.active], [[0.2], "touch"]);
});

test("the disk is released with the last source, and passes to the others without a jump", () => {
  const { input, sent } = opened();
  input.moveTo("twist", 0.2);
  input.moveTo("touch", 0.3);
  input.moveTo("touch", 0.6);
  input.moveTo("twist", 0.9);
  const held = input.position;
  input.release("touch");
  assert.deepEqual([input.active, input.position, sent.includes("release")], ["twist", held, false]);
  input.moveTo("twist", 0.91);
  assert.ok(Math.abs(sent.at(-1) - held) <= 0.015 + 1e-12);
  input.release("twist");
  assert.deepEqual([input.active, sent.at(-1)], [null, "release"]);
  input.release("twist");
  assert.equal(sent.filter((one) => one === "release").length, 1);
});

test("a touch after a release begins where it touches", () => {
  const { input, sent } = opened();
  input.moveTo("touch", 0.2);
  input.moveTo("twist", 0.9);
  input.releaseAll();
  input.moveTo("twist", 0.7);
  input.moveTo("twist", 0.75);
  assert.deepEqual([sent.slice(-2), input.position], [[0.7, 0.75], 0.75]);
});

test("a key touches again at each stop", () => {
  const { input, sent } = opened();
  input.touchAgain("keys", 0.3);
  input.touchAgain("keys", 0.31);
  assert.deepEqual(sent, [0.3, "release", 0.31]);
});

test("a tap releases, and changes nothing while another source touches", () => {
  const { input, sent } = opened();
  input.tap("keys", 0.4);
  assert.deepEqual([sent, input.active], [[0.4, "release"], null]);
  input.moveTo("touch", 0.5);
  input.tap("keys", 0.9);
  assert.deepEqual([sent.slice(2), input.active, input.position], [[0.5], "touch", 0.5]);
});

test("a change of the window moves keys and a released disk, but no finger", () => {
  const { input, sent } = opened();
  input.stayAt(0.3);
  assert.deepEqual([sent, input.position], [[], 0.3]);
  input.moveTo("keys", 0.3);
  input.stayAt(0.6);
  assert.deepEqual(sent, [0.3, "release", 0.6]);
  input.release("keys");
  input.moveTo("touch", 0.2);
  input.stayAt(0.8);
  assert.deepEqual([sent.at(-1), input.position], [0.2, 0.2]);
});
