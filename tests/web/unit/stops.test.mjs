import assert from "node:assert/strict";
import test from "node:test";
import { csvOf, rowsOf } from "../../../overview_dsp/web/site/all_values.js";
import { positionText } from "../../../overview_dsp/web/site/descriptions.js";
import { allStops, eventStops, nextStop, valueStops } from "../../../overview_dsp/web/site/stops.js";

const INFO = {
  title: "t", start: null, duration_s: 1000, series: { decimals: 0, unit: "V", complete: true },
  kinds: { peak: { name: "peak" }, note: { name: "note" } },
};

/** A generator of numbers from 0 to 1 (mulberry32). */
function random(seed) {
  return () => {
    seed = (seed + 0x6d2b79f5) | 0;
    let t = Math.imul(seed ^ (seed >>> 15), 1 | seed);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
}

function someView(seed, points, events) {
  const next = random(seed);
  const times = Array.from({ length: points }, () => Math.floor(next() * 1e6) / 1e3);
  const time_s = [...new Set(times)].sort((a, b) => a - b);
  const [from, to] = [0.4, 0.5];
  const outside = time_s.filter((one) => one / 1000 <= from || one / 1000 >= to);
  const found = Array.from({ length: events }, (_, i) => {
    const isAtPoint = points > 0 && i % 2 === 0;
    const moment = isAtPoint ? outside[Math.floor(next() * outside.length)] : Math.floor(next() * 1e6) / 1e3;
    return { kind: "note", label: `event ${i}.`, time_s: moment, position: moment / 1000 };
  }).sort((a, b) => a.time_s - b.time_s);
  return {
    start_s: 0, end_s: 1000, angle_map: null, level: [0, 1], scale: [0, 1],
    gaps: points > 0 ? [[from, to]] : [], events: found,
    points: points > 0 ? { time_s: outside, value: outside.map((_, i) => i + 1) } : null,
  };
}

function walk(view, stops, direction, withValue = false) {
  const texts = [];
  let position = direction > 0 ? -1 : 2;
  for (;;) {
    position = nextStop(stops, position, direction);
    if (position === undefined) return texts;
    texts.push(positionText(view, position, INFO, withValue));
  }
}

for (const [seed, points, events] of [[1, 12, 0], [2, 40, 7], [3, 500, 60], [4, 0, 30], [5, 3000, 400]]) {
  test(`arrows meet each of ${points} values and ${events} events exactly once`, () => {
    const view = someView(seed, points, events);
    for (const direction of [1, -1]) {
      const text = walk(view, allStops(view), direction).join("\n");
      for (const value of view.points?.value ?? []) {
        const alone = [...text.matchAll(new RegExp(`^${value} V, `, "gm"))].length;
        assert.equal(alone, 1, `value ${value}`);
      }
      for (const { label } of view.events) {
        assert.equal(text.split(label).length - 1, 1, label);
      }
    }
    assert.equal(valueStops(view).length, view.points?.value.length ?? 0);
    const texts = walk(view, eventStops(view), 1, true).join("\n");
    for (const { label } of view.events) assert.equal(texts.split(label).length - 1, 1, label);
  });
}

test("a window without values has steps between its events, not on them", () => {
  const view = someView(4, 0, 30);
  const stops = allStops(view);
  assert.ok(stops.length > 60);
  const texts = walk(view, stops, 1);
  assert.equal(texts.filter((text) => text.includes("event")).length, eventStops(view).length);
});

test("the table has each value once, and quotes what a comma would split", () => {
  const view = someView(2, 40, 7);
  view.events[0].label = 'a "quoted", label';
  const rows = rowsOf(view, INFO);
  const lines = csvOf(rows, INFO).split("\r\n");
  assert.equal(lines[0], "time_s,value (V),events");
  assert.ok(lines.some((line) => line.includes('a ""quoted"", label')));
  const times = rows.map(({ time_s }) => time_s);
  assert.deepEqual(times, times.toSorted((a, b) => a - b));
  // an event is at its own time, and never moved to that of a value
  for (const { label, time_s } of view.events) {
    const [row, ...more] = rows.filter(({ events }) => events.includes(label));
    assert.equal(more.length, 0, label);
    assert.ok(Math.abs(row.time_s - time_s) < 1e-6, label);
  }
  const days = { ...INFO, start: "2024-02-28T00:00:00+01:00" };
  assert.ok(csvOf([{ time_s: 172800, value: 3, events: "" }], days).includes("2024-03-01T00:00:00+01:00,3,"));
});
