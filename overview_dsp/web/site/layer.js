// The static picture: curve, axis, events and the disk's scale. It is drawn again only if the window,
// the size or the colours change.

import { positionAt, stretched } from "./angle_map.js";
import { angleOf } from "./geometry.js";
import { drawMark } from "./marks.js";
import { linesOf } from "./values.js";
import { momentText, tickText } from "./descriptions.js";

/** @import { Colours, Disk, Geometry, Info, TimelineEvent, TraceBox, View } from "../types" */
/** @import { SvgContext } from "./svg.js" */

const FAMILY = 'system-ui, -apple-system, "Segoe UI", Roboto, "Noto Sans", sans-serif';
/** @param {Geometry} g */
const fontOf = (g, weight = 400) => `${weight} ${(13 * g.em).toFixed(1)}px ${FAMILY}`;
const VALUE_PX = 34; // minimum distance of two value lines
const MOST_DETAILS = 400; // maximum number of details that are drawn
const STEPS_S = [1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 10800, 21600, 43200,
  86400, 604800, 2629800, 7889400, 31557600, 157788000, 315576000];
const BETWEEN = 30; // minimum distance (px) of two labels

/**
 * @typedef {object} Scene
 * @property {SvgContext} c
 * @property {Geometry} g
 * @property {View} view
 * @property {Info} info
 * @property {Colours} colours
 */

/** @param {Scene} scene */
export function drawLayer(scene) {
  const { g, view, info } = scene;
  drawGaps(scene);
  drawCurve(scene);
  if (info.series) drawValues(scene);
  drawAxis(scene);
  drawStretched(scene);
  drawEvents(scene);
  drawLabels(scene);
  if (typeof view.now === "number") drawNow(scene, view.now);
  if (g.disk) drawScale(scene, g.disk);
  if (g.trace) drawTraceAxis(scene, g.trace);
}

/**
 * @param {SvgContext} c
 * @param {[number, number]} from
 * @param {[number, number]} to
 */
function drawLine(c, from, to) {
  c.beginPath();
  c.moveTo(...from);
  c.lineTo(...to);
  c.stroke();
}

/**
 * @param {Scene} scene
 * @param {TraceBox} box
 */
function drawTraceAxis({ c, g, colours }, { left, right, y, half }) {
  c.strokeStyle = colours.line;
  c.lineWidth = 1;
  drawLine(c, [left, y + 0.5], [right, y + 0.5]);
  c.font = fontOf(g);
  c.fillStyle = colours.soft;
  c.textAlign = "left";
  c.textBaseline = "bottom";
  c.fillText("torque of the last seconds", left, y - half + 2);
}

/**
 * Draw one line for each of a few round values, with the value at its left.
 * @param {Scene} scene
 */
function drawValues({ c, g, view, colours }) {
  const most = Math.max(2, Math.floor((g.bottom - g.top) / (VALUE_PX * g.em)));
  c.font = fontOf(g);
  c.textAlign = "left";
  c.textBaseline = "bottom";
  c.lineWidth = 1;
  for (const { text, level } of linesOf(view.scale, most)) {
    const y = Math.round(g.y(level)) + 0.5;
    c.strokeStyle = colours.line;
    drawLine(c, [g.left, y], [g.right, y]);
    c.lineWidth = 3;
    c.strokeStyle = colours.paper;
    c.strokeText(text, g.left + 2, y - 1);
    c.lineWidth = 1;
    c.fillStyle = colours.soft;
    c.fillText(text, g.left + 2, y - 1);
  }
}

/**
 * Return the curve's level at a position, 0 to 1; null without data.
 * @param {View} view
 * @param {number} position
 */
export function levelAt(view, position) {
  return view.level[Math.round(position * (view.level.length - 1))];
}

/**
 * Return the level of an event's mark, 0 to 1.
 * @param {View} view
 * @param {TimelineEvent} event
 */
export function markLevel(view, event) {
  const [low, span] = view.scale;
  if (event.value === undefined || !(span > 0)) return levelAt(view, event.position) ?? 0;
  return Math.min(Math.max((event.value - low) / span, 0), 1);
}

/**
 * Return the friction at a position, N m s/rad.
 * @param {View} view
 * @param {number} position
 */
export function resistanceAt(view, position) {
  return view.resistance[Math.round(position * (view.resistance.length - 1))];
}

/**
 * Draw the curve, interrupted where there are no data; for many points per column, their range.
 * @param {Scene} scene
 */
function drawCurve({ c, g, view, colours }) {
  const last = view.level.length - 1;
  const [lows, highs] = view.band ?? [view.level, view.level];
  /** @type {[number, number][][]} */
  const runs = [[]];
  for (let i = 0; i <= last; i += 1) {
    const run = runs[runs.length - 1];
    const [low, high] = [lows[i], highs[i]];
    if (low === null || high === null) {
      if (run.length > 0) runs.push([]);
      continue;
    }
    const ends = [g.y(low), g.y(high)];
    // from the end that is nearer to the column before
    if (run.length > 0 && run[run.length - 1][1] < (ends[0] + ends[1]) / 2) ends.reverse();
    run.push([g.x(i / last), ends[0]]);
    if (ends[1] !== ends[0]) run.push([g.x(i / last), ends[1]]);
  }
  for (const run of runs) {
    if (run.length === 0) continue;
    c.beginPath();
    for (const point of run) c.lineTo(...point);
    c.lineTo(run[run.length - 1][0], g.bottom);
    c.lineTo(run[0][0], g.bottom);
    c.fillStyle = colours.fill;
    c.fill();
  }
  c.beginPath();
  for (const run of runs) {
    run.forEach((point, i) => (i === 0 ? c.moveTo(...point) : c.lineTo(...point)));
    if (run.length === 1) c.arc(...run[0], 1.5, 0, 2 * Math.PI); // a point between two gaps
  }
  c.strokeStyle = colours.curve;
  c.lineWidth = 1.75;
  c.stroke();
}

/**
 * Draw hatched gaps, each line clipped to its gap.
 * @param {Scene} scene
 */
function drawGaps({ c, g, view, colours }) {
  c.strokeStyle = colours.line;
  c.lineWidth = 1;
  c.beginPath();
  for (const [from, to] of view.gaps) {
    const [left, right] = [g.x(from), g.x(to)];
    for (let x = left - (g.bottom - g.top); x < right; x += 8) {
      const start = Math.max(x, left);
      const end = Math.min(x + g.bottom - g.top, right);
      c.moveTo(start, g.bottom - (start - x));
      c.lineTo(end, g.bottom - (end - x));
    }
  }
  c.stroke();
}

/**
 * Draw a line and a label where the known data end.
 * @param {Scene} scene
 * @param {number} now
 */
function drawNow({ c, g, colours }, now) {
  const x = g.x(now);
  c.strokeStyle = colours.ink;
  c.lineWidth = 1.5;
  drawLine(c, [x, g.top], [x, g.bottom]);
  c.font = fontOf(g, 600);
  const before = x + 4 + c.measureText("now").width > g.right;
  c.textAlign = before ? "right" : "left";
  c.textBaseline = "bottom";
  c.lineWidth = 3;
  c.strokeStyle = colours.paper;
  c.strokeText("now", before ? x - 4 : x + 4, g.bottom - 4);
  c.fillStyle = colours.ink;
  c.fillText("now", before ? x - 4 : x + 4, g.bottom - 4);
}

/** @param {Scene} scene */
function drawAxis({ c, g, view, info, colours }) {
  const length = view.end_s - view.start_s;
  c.font = fontOf(g);
  const { width } = c.measureText(momentText(view.end_s, info));
  const most = Math.max(2, (g.right - g.left) / (width + BETWEEN));
  const step = STEPS_S.find((one) => length / one <= most) ?? length;
  c.strokeStyle = colours.line;
  c.lineWidth = 1;
  c.beginPath();
  c.moveTo(g.left, g.bottom + 0.5);
  c.lineTo(g.right, g.bottom + 0.5);
  c.fillStyle = colours.soft;
  c.textBaseline = "top";
  let free = g.left; // x from which there is room for a label
  for (let at = Math.ceil(view.start_s / step) * step; at <= view.end_s; at += step) {
    const x = g.x(positionAt(view, at));
    c.moveTo(x, g.bottom + 0.5);
    c.lineTo(x, g.bottom + 6);
    const text = tickText(at, info, step);
    const half = c.measureText(text).width / 2;
    const left = Math.min(Math.max(x - half, g.left), g.right - 2 * half);
    if (left < free) continue;
    c.textAlign = "left";
    c.fillText(text, left, g.bottom + 10);
    free = left + 2 * half + BETWEEN / 3;
  }
  c.stroke();
}

/**
 * Draw a bold axis where time is stretched to separate close events (`about.js`).
 * @param {Scene} scene
 */
function drawStretched({ c, g, view, colours }) {
  c.strokeStyle = colours.soft;
  c.lineWidth = 3;
  c.beginPath();
  for (const [from, to] of stretched(view)) {
    c.moveTo(g.x(from), g.bottom + 1.5);
    c.lineTo(g.x(to), g.bottom + 1.5);
  }
  c.stroke();
}

/** @param {Scene} scene */
function drawEvents(scene) {
  const { c, g, view, info, colours } = scene;
  // details have a row of their own: there may be hundreds
  const details = view.events.filter(({ kind }) => isDetail(info, kind));
  const every = Math.ceil(details.length / MOST_DETAILS);
  details.forEach((event, i) => {
    if (i % every > 0) return;
    const { shape, colour } = info.kinds[event.kind];
    drawMark(c, shape, g.x(event.position), g.bottom - 8, 3.5, colours[colour], colours.rim);
  });
  for (const event of view.events) {
    if (!isDetail(info, event.kind)) drawEvent(scene, event);
  }
}

const MANY = 200; // events of a kind that would hide the curve, such as heartbeats

/**
 * Return whether events of a kind are drawn in the row at the bottom.
 * @param {Info} info
 * @param {string} kind
 */
export function isDetail(info, kind) {
  return info.kinds[kind].count === 0 || info.kinds[kind].count > MANY;
}

/**
 * @param {Scene} scene
 * @param {TimelineEvent} event
 */
function drawEvent({ c, g, view, info, colours }, event) {
  const { shape, colour } = info.kinds[event.kind];
  const x = g.x(event.position);
  const y = g.y(markLevel(view, event));
  c.strokeStyle = colours.line;
  c.lineWidth = 1;
  drawLine(c, [x, y], [x, g.bottom]);
  drawMark(c, shape, x, y, 6, colours[colour], colours.rim);
}

/**
 * Draw the score of each goal above it; the last goals first, where there is room.
 * @param {Scene} scene
 */
function drawLabels({ c, g, view, colours }) {
  c.font = fontOf(g, 600);
  c.fillStyle = colours.ink;
  c.textAlign = "center";
  c.textBaseline = "alphabetic";
  /** @type {[number, number][]} */
  const taken = [];
  for (const event of [...view.events].reverse()) {
    if (event.kind !== "goal" && event.kind !== "own_goal") continue;
    const text = event.label.split(" ")[0];
    const half = c.measureText(text).width / 2;
    const x = Math.min(Math.max(g.x(event.position), half), g.width - half);
    if (!text || taken.some(([from, to]) => x + half + 6 > from && x - half - 6 < to)) continue;
    c.fillText(text, x, Math.max(g.y(markLevel(view, event)) - 15, 13 * g.em));
    taken.push([x - half, x + half]);
  }
}

/**
 * Draw the disk's scale with the events on it.
 * @param {Scene} scene
 * @param {Disk} disk
 */
function drawScale({ c, view, info, colours }, { x, y, radius }) {
  c.strokeStyle = colours.line;
  c.lineWidth = 2;
  c.beginPath();
  c.arc(x, y, radius, angleOf(0), angleOf(1));
  c.stroke();
  for (const event of view.events) {
    const { colour } = info.kinds[event.kind];
    if (isDetail(info, event.kind)) continue;
    const angle = angleOf(event.position);
    const light = colour === "grey";
    const out = light ? 7 : 12;
    c.strokeStyle = colours[colour];
    c.lineWidth = light ? 1.5 : 3;
    drawLine(c, [x + (radius + 2) * Math.cos(angle), y + (radius + 2) * Math.sin(angle)], [x + (radius + out) * Math.cos(angle), y + (radius + out) * Math.sin(angle)]);
  }
}
