import assert from "node:assert/strict";
import test from "node:test";
import { positionAt, secondsAt } from "../../../overview_dsp/web/site/angle_map.js";
import { eventAt, eventText, gapText, positionText } from "../../../overview_dsp/web/site/descriptions.js";
import { positionTurned } from "../../../overview_dsp/web/site/geometry.js";
import { markLevel, rareKinds } from "../../../overview_dsp/web/site/layer.js";
import { extremeOf, linesOf, pointAt, rangeOf, valueText } from "../../../overview_dsp/web/site/values.js";
import { ticksOf } from "../../../overview_dsp/web/site/ticks.js";
import {
  croppedTo, partBetween, neighbourPart, partNearest,
} from "../../../overview_dsp/web/site/windows.js";

test("the disk is turned over the top, and stays at the end it was turned to", () => {
  const disk = { x: 100, y: 100, radius: 50 };
  assert.equal(positionTurned(disk, 60, 100, 0), 0);
  assert.equal(positionTurned(disk, 100, 50, 0.4), 0.5);
  assert.equal(positionTurned(disk, 140, 100, 0.9), 1);
  assert.equal(positionTurned(disk, 60, 130, 0.9), 1);
  assert.equal(positionTurned(disk, 140, 130, 0.1), 0);
});

test("the nearest point is the one before or after, whichever is nearer", () => {
  const view = { points: { time_s: [0, 10, 30], value: [1, 2, 3] } };
  for (const [moment, point] of [[-5, 0], [4, 0], [6, 1], [19, 1], [21, 2], [99, 2]]) {
    assert.equal(pointAt(view, moment), point);
  }
  assert.equal(pointAt({ points: null }, 3), -1);
});

const SERIES = {
  start: "2008-07-01T00:00:00", duration_s: 864000,
  series: { decimals: 2, unit: "dollars", has_times: false },
  kinds: { peak: { name: "peak" }, largest_fall: { name: "largest fall" }, month: { name: "month" } },
};

test("the highest point is announced as itself, also beside an event", () => {
  const event = { kind: "peak", label: "peak 143.74, 2008-07-02", time_s: 86400, position: 0.1 };
  const view = {
    start_s: 0, end_s: 864000, angle_map: null, gaps: [], events: [event],
    points: { time_s: [0, 86400, 87400, 864000], value: [1, 143.74, 145.31, 2] },
  };
  const highest = extremeOf(view, 1);
  assert.equal(positionText(view, highest, SERIES), "145.31 dollars, 2 July 2008");
  assert.equal(eventAt(view, 0.1), event);
  assert.equal(eventAt(view, 0.1005), event, "a finger is rarely on a point exactly");
  assert.equal(positionText(view, 0.1005, SERIES), "143.74 dollars, 2 July 2008, peak");
});

test("no date, value or kind occurs twice in the text of an event", () => {
  /** @type {(kind: string, label: string, value?: number, change?: [number, string]) => string} */
  const text = (kind, label, value, change) => eventText({ kind, label, value, change, time_s: 0, position: 0 }, SERIES);
  assert.equal(text("peak", "peak 143.74, 2008-07-02", 143.74), "peak, 143.74 dollars");
  assert.equal(text("largest_fall", "", 90.1, [-5.2, "%"]), "largest fall, \u22125.20 %, 90.10 dollars");
  assert.equal(text("largest_fall", "", 90.1, [-5.2, "dollars"]), "largest fall, \u22125.20 dollars, 90.10 dollars");
  assert.equal(text("largest_fall", "", 90.1), "largest fall, 90.10 dollars");
  assert.equal(text("month", "August 2008", 1), "month begins");
  assert.equal(text("launch", "the launch of A", 1), "the launch of A");
});

test("within a gap the moments of its ends are told", () => {
  const view = { start_s: 0, end_s: 864000, angle_map: null, gaps: [[0.1, 0.5]], events: [], points: null };
  assert.equal(gapText(view, 0.3, SERIES), "2 Jul 2008 to 6 Jul 2008");
  assert.deepEqual([0.05, 0.5, 0.9].map((position) => gapText(view, position, SERIES)), ["", "", ""]);
});

test("levels without data are neither extremes nor marks", () => {
  const view = { level: [null, 0.4, null, 0.2, 0.9, null], points: null, scale: [10, 20] };
  assert.equal(extremeOf(view, 1), 0.8);
  assert.equal(extremeOf(view, -1), 0.6);
  assert.deepEqual(rangeOf(view), [0.2, 0.9]);
  assert.equal(markLevel(view, { position: 0.4 }), 0);
  assert.equal(markLevel(view, { position: 0.4, value: 15 }), 0.25);
});

test("a value is told with its decimals and its unit", () => {
  assert.equal(valueText(702.1, { series: { decimals: 2, unit: "dollars" } }), "702.10 dollars");
  assert.equal(valueText(-3.04, { series: { decimals: 1, unit: "" } }), "\u22123.0");
  assert.equal(valueText(undefined, { series: { decimals: 1, unit: "" } }), "");
});

test("lines of values are round, and few", () => {
  const lines = linesOf([0.9, 83.5], 5);
  assert.deepEqual(lines.map(({ text }) => text), ["20", "40", "60", "80"]);
  assert.deepEqual(linesOf([1, 0], 5), []);
  assert.deepEqual(linesOf([-9, 19], 3).map(({ text }) => text), ["0", "10"]);
});

test("a window of its own has neighbours", () => {
  const windows = [
    { level: 0, start_s: 0, end_s: 90 }, { level: 1, start_s: 0, end_s: 30 },
    { level: 1, start_s: 30, end_s: 60 }, { level: 1, start_s: 60, end_s: 90 },
  ];
  const part = partBetween(windows, [20, 50]);
  assert.deepEqual([part.number, part.zoom], [-1, 1]);
  assert.equal(neighbourPart(windows, part, 1).start_s, 30);
});

test("a view cropped to a window of it has what lies there, at its positions", () => {
  const level = Array.from({ length: 101 }, (_, i) => i / 100);
  const view = {
    start_s: 0, end_s: 1000, level, gaps: [[0.1, 0.3], [0.8, 0.9]],
    events: [{ position: 0.2 }, { position: 0.5 }, { position: 0.7 }],
  };
  const cropped = croppedTo(view, [250, 750]);
  assert.deepEqual([cropped.level[0], cropped.level[50], cropped.level[100]], [0.25, 0.5, 0.75]);
  assert.deepEqual(cropped.events.map(({ position }) => position.toFixed(2)), ["0.50", "0.90"]);
  assert.equal(cropped.gaps.length, 1);
  assert.equal(cropped.gaps[0][0], 0);
  assert.ok(Math.abs(cropped.gaps[0][1] - 0.1) < 1e-9);
});

const MAPPED = {
  start_s: 100, end_s: 1100,
  angle_map: { time_s: [100, 200, 210, 210, 1100], position: [0, 0.25, 0.5, 0.75, 1] },
};

test("moments and positions of a mapped window lead to each other", () => {
  const moments = [100, 150, 200, 205, 600, 1100];
  const positions = [0, 0.125, 0.25, 0.375, 0.75 + (0.25 * 390) / 890, 1];
  moments.forEach((moment, i) => {
    assert.ok(Math.abs(positionAt(MAPPED, moment) - positions[i]) < 1e-12, `${moment}`);
    assert.ok(Math.abs(secondsAt(MAPPED, positions[i]) - moment) < 1e-9, `${moment}`);
  });
  // of events at one moment the last one's position; in between it stands still
  assert.equal(positionAt(MAPPED, 210), 0.75);
  assert.equal(secondsAt(MAPPED, 0.6), 210);
  assert.deepEqual([positionAt(MAPPED, 0), positionAt(MAPPED, 2000)], [0, 1]);
  const linear = { start_s: 100, end_s: 1100, angle_map: null };
  assert.deepEqual([positionAt(linear, 350), secondsAt(linear, 0.25), positionAt(linear, 0)], [0.25, 350, 0]);
});

test("a cropped window keeps the map of what it shows", () => {
  const level = Array.from({ length: 101 }, (_, i) => i / 100);
  const view = { ...MAPPED, level, gaps: [], events: [{ position: 0.5 }] };
  const ends = [150, 600];
  const cropped = croppedTo(view, ends);
  const [from, to] = ends.map((moment) => positionAt(view, moment));
  assert.ok(Math.abs(cropped.events[0].position - (0.5 - from) / (to - from)) < 1e-12);
  for (const moment of [150, 190, 207, 300, 600]) {
    const wanted = (positionAt(view, moment) - from) / (to - from);
    assert.ok(Math.abs(positionAt(cropped, moment) - wanted) < 1e-12, `${moment}`);
  }
  assert.ok(Math.abs(cropped.level[0] - from) < 0.01);
});

test("the nearest window is as long as any and about the same moment", () => {
  const windows = [{ level: 0, start_s: 0, end_s: 900 }];
  for (let i = 0; i < 5; i += 1) windows.push({ level: 1, start_s: 150 * i, end_s: 150 * i + 300 });
  assert.equal(partNearest(windows, [0, 700]).zoom, 0);
  assert.equal(partNearest(windows, [300, 700]).zoom, 1);
  assert.equal(partNearest(windows, [310, 590]).start_s, 300);
});

test("ticks are at round times and at the beginnings of years, as many as have room", () => {
  const fits = (most) => (_, count) => count <= most;
  const match = { start: null, duration_s: 5880, series: null };
  const view = { start_s: 0, end_s: 5880 };
  assert.deepEqual(ticksOf(view, match, fits(4)).map(({ text }) => text), ["0\u2032", "30\u2032", "60\u2032", "90\u2032"]);
  const price = { start: "2000-03-01T00:00:00", duration_s: 4000 * 86400, series: { has_times: false } };
  const days = { start_s: 0, end_s: 4000 * 86400 };
  assert.deepEqual(ticksOf(days, price, fits(6)).map(({ text }) => text), ["2002", "2004", "2006", "2008", "2010"]);
  assert.equal(ticksOf(days, price, fits(6))[0].at, 671 * 86400);
  const part = ticksOf({ start_s: 0, end_s: 200 * 86400 }, price, fits(12));
  assert.ok(part.length <= 12 && part.length > 2);
});

test("the ticks of every length are two at least, with labels that differ and are short", () => {
  const DAY = 86400;
  const fits = (text, count) => count * (6.5 * text.length + 24) <= 254; // of a narrow phone
  const calendar = "2000-03-01T09:30:00";
  const words = (start, days, from = 0, to = days) => ticksOf({ start_s: from * DAY, end_s: to * DAY },
    { start, duration_s: days * DAY, series: { has_times: false } }, fits).map(({ text }) => text);
  for (const start of [null, calendar]) {
    for (let days = 1; days < 2e6; days *= 1.3) {
      for (const labels of [words(start, days), words(start, days, 0.4 * days, 0.52 * days)]) {
        assert.ok(labels.length > 1, `${start} ${days}`);
        const clocks = labels.filter((text) => !/^\d\d:|^[A-Z]/.test(text)); // the same in each day or year
        assert.equal(new Set(clocks).size, clocks.length, `${start} ${days}: ${labels}`);
        assert.ok(labels.every((text) => text.length <= 13), `${start} ${days}: ${labels}`);
      }
    }
  }
  assert.deepEqual(words(null, 40), ["0 days", "20 days", "40 days"]);
  assert.deepEqual(words(null, 40000), ["0 years", "50 years", "100 years"]);
  assert.deepEqual(words(calendar, 2.5), ["Thu", "Fri"]);
  assert.deepEqual(words(calendar, 5), ["2 Mar", "4 Mar", "6 Mar"]);
  assert.deepEqual(words(calendar, 40), ["6 Mar", "20 Mar", "3 Apr"]);
  assert.deepEqual(words(calendar, 330), ["Apr", "Jul", "Oct", "2001"]);
  assert.deepEqual(words(calendar, 4e5), ["2500", "3000"]);
});

test("the rarest kinds keep their marks on a crowded timeline", () => {
  const counts = new Map([["beat", 1500], ["paced", 20], ["early", 4], ["noise", 20], ["rhythm", 12]]);
  assert.deepEqual(rareKinds(counts, 30), new Set(["early", "rhythm"]));
  assert.deepEqual(rareKinds(counts, 40), new Set(["early", "rhythm", "paced"]));
  assert.deepEqual(rareKinds(counts, 9), new Set(["early", "rhythm"]));
  assert.equal(rareKinds(counts, 2000).size, 5);
});
