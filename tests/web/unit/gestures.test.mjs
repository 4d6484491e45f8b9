import assert from "node:assert/strict";
import test from "node:test";
import { momentAt, eventName } from "../../../overview_dsp/web/site/address.js";
import { gestureOf, gestureText } from "../../../overview_dsp/web/site/player.js";

test("a gesture is read as the command line reads it, and written so again", () => {
  for (const words of ["sweep:10", "sweep:2.5:0.2:0.8", "tap:0.8"]) {
    assert.equal(gestureText(gestureOf(words)), words);
  }
});

test("what is no gesture is none", () => {
  for (const words of [null, "", "dance", "sweep:0", "sweep:x", "sweep:2:0:1.5", "tap", "tap:2"]) {
    assert.equal(gestureOf(words), null, words);
  }
});

const EVENTS = [
  { kind: "goal", time_s: 10 }, { kind: "foul", time_s: 20 }, { kind: "goal", time_s: 4050 },
];

test("a position is an event, a clock or seconds", () => {
  assert.equal(momentAt("goal:2", EVENTS), 4050);
  assert.equal(momentAt("goal", EVENTS), 10);
  assert.equal(momentAt("67:30", EVENTS), 4050);
  assert.equal(momentAt("1:07:30", EVENTS), 4050);
  assert.equal(momentAt("12.5", EVENTS), 12.5);
  for (const nothing of ["goal:3", "corner", "goal:x", "goal\n2", ""]) {
    assert.equal(momentAt(nothing, EVENTS), null);
  }
});

test("an event's name leads to it again", () => {
  for (const event of EVENTS) assert.equal(momentAt(eventName(event, EVENTS), EVENTS), event.time_s);
});
