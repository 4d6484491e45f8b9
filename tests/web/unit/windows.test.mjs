import assert from "node:assert/strict";
import test from "node:test";
import {
  firstPart, lastLevel, neighbourPart, partAround, partBetween, partContaining, partOf,
} from "../../../overview_dsp/web/site/windows.js";

const DURATION = 5400;
const WINDOWS = [];
for (let level = 0; level <= 4; level += 1) {
  const width = DURATION / 3 ** level;
  for (let i = 0; i < 2 * 3 ** level - 1; i += 1) {
    WINDOWS.push({ level, start_s: (i * width) / 2, end_s: i === 2 * 3 ** level - 2 ? DURATION : (i * width) / 2 + width });
  }
}
const PARTS = WINDOWS.map((_, i) => partOf(WINDOWS, i));
const near = (a, b) => Math.abs(a - b) < 1e-6;
const lengthOf = ({ start_s, end_s }) => end_s - start_s;

/** Windows of many lengths at many places, as a host or a link may show them. */
const OTHERS = Array.from({ length: 200 }, (_, i) => {
  const length = 10 + ((i * 37) % 1990);
  const start = (i * 613.7) % (DURATION - length);
  return [start, start + length];
});

test("neighbours overlap by half, and lead from the start to the end and back", () => {
  for (let level = 1; level <= lastLevel(WINDOWS); level += 1) {
    let part = partAround(WINDOWS, level, 0);
    assert.equal(part.start_s, 0);
    assert.equal(neighbourPart(WINDOWS, part, -1), null);
    for (let next = part; next !== null; next = neighbourPart(WINDOWS, part, 1)) {
      if (next !== part) {
        assert.ok(near(next.start_s, (part.start_s + part.end_s) / 2), `level ${level}, ${next.number}`);
        assert.deepEqual(neighbourPart(WINDOWS, next, -1), part);
      }
      part = next;
    }
    assert.ok(near(part.end_s, DURATION));
  }
});

test("the whole timeline has no neighbour", () => {
  for (const direction of [-1, 1]) assert.equal(neighbourPart(WINDOWS, PARTS[0], direction), null);
});

test("a window that is not listed has neighbours of its level, until an end is reached", () => {
  for (const ends of OTHERS) {
    for (const direction of [-1, 1]) {
      let part = partBetween(WINDOWS, ends);
      assert.equal(part.number, -1);
      const { zoom } = part;
      for (let steps = 0; part !== null; steps += 1) {
        assert.ok(steps <= WINDOWS.length, "no end");
        assert.equal(part.zoom, zoom);
        const next = neighbourPart(WINDOWS, part, direction);
        if (next !== null) assert.ok(direction > 0 ? next.end_s > part.end_s : next.start_s < part.start_s);
        else if (zoom > 0) assert.ok(near(direction > 0 ? part.end_s : part.start_s, direction > 0 ? DURATION : 0));
        part = next;
      }
    }
  }
});

test("a listed window is found by its ends, also if they were rounded", () => {
  for (const part of PARTS) {
    for (const by of [0, 4e-7]) assert.deepEqual(partBetween(WINDOWS, [part.start_s + by, part.end_s - by]), part);
  }
});

test("another window keeps its ends, with the zoom of the narrowest windows that are as long", () => {
  for (const [start, end] of OTHERS) {
    const part = partBetween(WINDOWS, [start, end]);
    assert.deepEqual([part.start_s, part.end_s], [start, end]);
    const as = (level) => lengthOf(WINDOWS.find((one) => one.level === level));
    assert.ok(as(part.zoom) >= end - start);
    if (part.zoom < lastLevel(WINDOWS)) assert.ok(as(part.zoom + 1) < end - start);
  }
});

test("the part that contains a window is the shortest that does", () => {
  for (const [start, end] of OTHERS) {
    const part = partContaining(WINDOWS, [start, end]);
    assert.ok(part.start_s <= start && part.end_s >= end);
    const shorter = PARTS.filter((one) => lengthOf(one) < lengthOf(part) - 1e-6);
    assert.ok(shorter.every((one) => one.start_s > start || one.end_s < end), `${start} ${end}`);
  }
  assert.equal(partContaining(WINDOWS, [0, DURATION]).number, 0);
});

test("the part around a moment contains it, and has the nearest middle", () => {
  for (let level = 0; level <= lastLevel(WINDOWS); level += 1) {
    for (let moment = 0; moment <= DURATION; moment += 97.3) {
      const part = partAround(WINDOWS, level, moment);
      assert.ok(part.zoom === level && part.start_s <= moment && part.end_s >= moment);
      const away = (one) => Math.abs((one.start_s + one.end_s) / 2 - moment);
      assert.ok(WINDOWS.every((one) => one.level !== level || away(one) >= away(part)));
    }
  }
  assert.equal(partAround(WINDOWS, lastLevel(WINDOWS) + 1, 0), null);
});

test("the first part is the server's window, or all", () => {
  const info = { windows: WINDOWS, duration_s: DURATION, server: null };
  assert.deepEqual(firstPart(info), PARTS[0]);
  const { number, start_s, end_s } = firstPart({ ...info, server: { window: [60, 90] } });
  assert.deepEqual([number, start_s, end_s], [-1, 60, 90]);
});
