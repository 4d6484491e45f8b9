// The static picture: curve, marks, axis and groove. It is drawn again only if the window, the size or
// the colours change.

import { positionAt } from "./angle_map.js";
import { drawKind, markOf } from "./marks.js";
import { isGoal, nameOf } from "./scores.js";
import { ticksOf } from "./ticks.js";
import { linesOf, valueText } from "./values.js";
import { NOW } from "./words.js";

/** @import { Colours, Geometry, Info, TimelineEvent, View } from "../types" */
/** @import { SvgContext } from "./svg.js" */

const FAMILY = 'system-ui, -apple-system, "Segoe UI", Roboto, "Noto Sans", sans-serif';
/** @param {{ em: number }} g */
export const fontOf = (g, weight = 400, size = 12) => `${weight} ${(size * g.em).toFixed(1)}px ${FAMILY}`;
const VALUE_PX = 48; // minimum distance of two value lines
const BETWEEN = 24; // minimum distance (px) of two labels
const AWAY = 17; // distance (px) of a mark from the curve
const CLOSE = 6; // distance (px) below which marks of a kind become a band
const RARE = 12; // events of a kind whose marks are always drawn
const BAND = 4; // px of a bar of the band
const TALLEST = 6; // px that a bar of the band has more for a number of events
const GROOVE = 9; // half height
const MANY = 200; // events of a kind that would hide the curve, such as heartbeats
const NEAR = 11; // distance (px) from a mark of a rarer kind at which frequent kinds are left out
const COMMON = 1.35; // a circle or hexagon of goals is larger than that of other kinds
const TALL = 600; // width (px) of a picture with larger marks
const LABELLED = 60; // height of a curve whose extremes are named
const BELOW = new Set(["lowest", "trough", "record_low", "largest_fall", "crossing_down"]);
export const EXTREMES = new Set(["highest", "lowest"]);

/**
 * @typedef {object} Scene
 * @property {SvgContext} c
 * @property {Geometry} g
 * @property {View} view
 * @property {Info} info
 * @property {Colours} colours
 * @property {Set<string>} hidden kinds that are not drawn
 */

/**
 * Draw the layer.
 * @param {Scene} scene
 */
export function drawLayer(scene) {
  const { view, info } = scene;
  drawGaps(scene);
  if (info.series) drawValues(scene);
  drawCurve(scene, "ahead");
  drawGroove(scene);
  drawEvents(scene);
  if (typeof view.now === "number") drawNow(scene, view.now);
}

/**
 * Draw the passed part of the curve, over the layer.
 * @param {Scene} scene
 */
export function drawPassed(scene) {
  drawCurve(scene, "curve");
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
 * Draw a text with a rim of paper.
 * @param {Scene} scene
 * @param {string} text
 * @param {number} x
 * @param {number} y
 * @param {string} colour
 */
function drawText({ c, colours }, text, x, y, colour) {
  c.lineWidth = 3;
  c.strokeStyle = colours.paper;
  c.strokeText(text, x, y);
  c.fillStyle = colours[colour];
  c.fillText(text, x, y);
}

/**
 * Return the round values of the axis.
 * @param {View} view
 * @param {number} height
 * @param {number} em
 */
export const figuresOf = (view, height, em) =>
  linesOf(view.scale, Math.max(1, Math.floor(height / (VALUE_PX * em))));

/**
 * Draw one line for each of a few round values, with the value at its right.
 * @param {Scene} scene
 */
function drawValues({ c, g, view, colours }) {
  c.font = fontOf(g);
  c.textAlign = "left";
  c.textBaseline = "alphabetic";
  c.lineWidth = 1;
  c.strokeStyle = colours.line;
  c.fillStyle = colours.soft;
  for (const { text, level } of figuresOf(view, g.bottom - g.top, g.em)) {
    const y = Math.round(g.y(level)) + 0.5;
    drawLine(c, [g.left, y], [g.right, y]);
    c.fillText(text, g.right + 8, y + 4 * g.em);
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
 * Draw the curve, interrupted where there are no data; for many points per column, their range.
 * @param {Scene} scene
 * @param {string} colour
 */
function drawCurve({ c, g, view, colours }, colour) {
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
    if (run.length === 0 || colour === "curve") continue; // the passed part lies over the marks
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
  c.strokeStyle = colours[colour];
  c.lineWidth = 2;
  c.stroke();
}

/**
 * Draw hatched gaps, each line clipped to its gap.
 * @param {Scene} scene
 */
function drawGaps({ c, g, view, colours }) {
  c.strokeStyle = colours.line;
  c.lineWidth = 1.5;
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
function drawNow(scene, now) {
  const { c, g, colours } = scene;
  const x = g.x(now);
  c.strokeStyle = colours.ink;
  c.lineWidth = 1.5;
  drawLine(c, [x, g.top], [x, g.bottom]);
  c.font = fontOf(g, 600);
  const before = x + 4 + c.measureText(NOW).width > g.right;
  c.textAlign = before ? "right" : "left";
  c.textBaseline = "bottom";
  drawText(scene, NOW, before ? x - 4 : x + 4, g.bottom - 4, "ink");
}

/**
 * Draw the groove, in spans of time that end at the ticks, and interrupted at gaps.
 * @param {Scene} scene
 */
function drawGroove({ c, g, view, info, colours }) {
  c.font = fontOf(g);
  const room = g.right - g.left;
  const ticks = ticksOf(view, info, (text, count) => count * (c.measureText(text).width + BETWEEN) <= room);
  c.strokeStyle = colours.edge;
  c.lineWidth = 1;
  drawLine(c, [g.left - 8, g.bottom + 0.5], [g.right + 8, g.bottom + 0.5]);
  const first = (ticks[0]?.number ?? 1) - 1; // of the span before the first tick
  const edges = [view.start_s, ...ticks.map(({ at }) => at), view.end_s];
  edges.slice(1).forEach((edge, i) => {
    const [left, right] = [edges[i], edge].map((at) => g.x(positionAt(view, at)));
    c.beginPath();
    if (i === 0) c.arc(left, g.groove, GROOVE, 0, 2 * Math.PI);
    if (i === edges.length - 2) c.arc(right, g.groove, GROOVE, 0, 2 * Math.PI);
    drawBox(c, left, right, g.groove, GROOVE);
    c.fillStyle = (first + i) % 2 === 0 ? colours.groove : colours.groove2;
    c.fill();
  });
  c.fillStyle = colours.paper;
  for (const [from, to] of view.gaps) {
    if (to >= 1 && typeof view.now === "number") continue; // the future stays a groove
    c.beginPath();
    drawBox(c, g.x(from), g.x(to), g.groove, GROOVE + 1);
    c.fill();
  }
  c.strokeStyle = colours.edge;
  c.fillStyle = colours.soft;
  c.textBaseline = "alphabetic";
  c.textAlign = "left";
  const y = g.groove + g.radius + 4 + 12 * g.em;
  let free = 0; // x from which there is room for a label
  for (const { at, text } of ticks) {
    const x = g.x(positionAt(view, at));
    drawLine(c, [x, g.groove + GROOVE + 4], [x, g.groove + GROOVE + 9]);
    const half = c.measureText(text).width / 2;
    const left = Math.min(Math.max(x - half, 2), g.width - 2 * half - 2);
    if (left < free) continue;
    c.fillText(text, left, y);
    free = left + 2 * half + BETWEEN / 3;
  }
}

/**
 * @param {SvgContext} c
 * @param {number} left
 * @param {number} right
 * @param {number} y
 * @param {number} half
 */
function drawBox(c, left, right, y, half) {
  c.moveTo(left, y - half);
  c.lineTo(right, y - half);
  c.lineTo(right, y + half);
  c.lineTo(left, y + half);
  c.closePath();
}

/**
 * Return the kinds that keep their marks on a crowded timeline: the rarest, while they have room.
 * @param {Map<string, number>} counts
 * @param {number} room number of marks
 */
export function rareKinds(counts, room) {
  let sum = 0;
  const rising = [...counts].sort(([, a], [, b]) => a - b);
  return new Set(rising.filter(([, count]) => (sum += count) <= room || count <= RARE).map(([kind]) => kind));
}

/** Return whether neither values nor a preset give a curve. @param {View} view */
const isFlat = ({ level }) => level.every((one) => !one);

/**
 * Return the place of an event's mark: in its team's lane above the curve, or near the curve of a series.
 * @param {Geometry} g
 * @param {View} view
 * @param {Info} info
 * @param {TimelineEvent} event
 * @returns {[number, number]}
 */
export function markPoint(g, view, info, event) {
  const x = g.x(event.position);
  if (!info.series) {
    const { lanes } = g;
    const middle = (lanes[0] + lanes[lanes.length - 1]) / 2;
    return [x, event.side ? lanes[event.side - 1] ?? middle : middle];
  }
  const y = g.y(markLevel(view, event)) + (BELOW.has(event.kind) ? AWAY : -AWAY);
  return [x, Math.min(Math.max(y, 8), g.bottom - 14)]; // above the band
}

/** @param {Scene} scene */
function drawEvents(scene) {
  const { c, g, view, info, colours, hidden } = scene;
  const size = g.width >= TALL ? 8 : 6.5;
  if (!isFlat(view) || view.events.length < MANY) {
    c.strokeStyle = colours.line;
    c.lineWidth = 2;
    for (const y of g.lanes) drawLine(c, [g.left, y], [g.right, y]);
  }
  const counts = new Map();
  for (const { kind } of view.events) counts.set(kind, (counts.get(kind) ?? 0) + 1);
  const rare = rareKinds(counts, (g.right - g.left) / 2 / CLOSE);
  /** @type {number[]} */
  const band = [];
  /** @type {Record<string, number>} */
  const lastX = {};
  /** @type {{ x: number, y: number, rank: number, draw: () => void }[]} */
  const marks = []; // `rank`: the count of its kind; the rarest are above all others
  for (const event of view.events) {
    const { kind, side } = event;
    if (hidden.has(kind)) continue;
    const [x, y] = markPoint(g, view, info, event);
    const isMain = isGoal(event) || EXTREMES.has(kind);
    const group = `${rare.has(kind) ? kind : ""} ${y}`;
    const { count, shape } = info.kinds[kind];
    const isTick = shape === "bar" && (kind !== "period" || info.series); // ticks of time stand on the axis
    const isDetail = counts.get(kind) > MANY || (count === 0 && !rare.has(kind)) || isTick;
    if (!isMain && (isDetail || x - (lastX[group] ?? -CLOSE) < CLOSE)) {
      band.push(x);
      continue;
    }
    lastX[group] = x;
    if (shape === "bar" && g.lanes.length > 1) {
      drawPart(scene, event, x);
      continue;
    }
    const mark = markOf(kind, info.kinds[kind], side);
    const round = !isMain && (shape === "circle" || shape === "hexagon");
    marks.push({
      x, y, rank: isMain ? 0 : counts.get(kind),
      draw: () => drawKind(c, mark, x, y, round ? size / COMMON : size, colours),
    });
  }
  if (isFlat(view) && band.length > 0) drawDensity(scene, band);
  else drawBand(scene, band);
  marks.sort((a, b) => b.rank - a.rank);
  /** @param {{ x: number, y: number, rank: number }} mark */
  const isHidden = ({ x, y, rank }) => rank > RARE
    && marks.some((one) => one.rank < rank && one.y === y && Math.abs(one.x - x) < NEAR);
  for (const mark of marks) if (info.series || !isHidden(mark)) mark.draw();
  drawLabels(scene);
}

/**
 * Draw a line through the picture where a part of a match begins or ends, with its name within the match.
 * @param {Scene} scene
 * @param {TimelineEvent} event
 * @param {number} x
 */
function drawPart(scene, { position, label }, x) {
  const { c, g, colours } = scene;
  c.strokeStyle = colours.edge;
  c.lineWidth = 1.5;
  drawLine(c, [x, g.lanes[0] - 7], [x, g.lanes[1] + 7]);
  if (position < 0.02 || position > 0.98) return;
  c.lineWidth = 1;
  for (let y = g.top + (g.radius < 20 ? 0 : 16 * g.em); y < g.bottom; y += 6) drawLine(c, [x, y], [x, y + 1.5]);
  if (g.radius < 20) return; // a low picture
  c.font = fontOf(g);
  c.textAlign = "center";
  c.textBaseline = "alphabetic";
  const half = c.measureText(label).width / 2;
  drawText(scene, label, Math.min(Math.max(x, half + 2), g.width - half - 2), g.top + 10 * g.em, "soft");
}

/**
 * Return the numbers of events for every 4 px, in order, as pairs of the left edge (px) and the number.
 * @param {number[]} band
 */
function densityOf(band) {
  const counts = new Map();
  for (const x of band) counts.set(Math.floor(x / BAND), (counts.get(Math.floor(x / BAND)) ?? 0) + 1);
  return [...counts].sort(([a], [b]) => a - b).map(([at, count]) => [at * BAND, count]);
}

/**
 * Draw events that are too many for marks: a bar for every 4 px, as high as their number.
 * @param {Scene} scene
 * @param {number[]} band
 */
function drawBand({ c, g, info, colours }, band) {
  const counts = densityOf(band);
  const most = Math.max(...counts.map(([, count]) => count));
  const y = info.series ? g.bottom : g.lanes[0] + 7;
  c.beginPath();
  for (const [x, count] of counts) {
    c.moveTo(x + BAND / 2, y);
    c.lineTo(x + BAND / 2, y - 3 - (TALLEST * count) / most);
  }
  c.strokeStyle = colours.edge;
  c.lineWidth = BAND - 1;
  c.stroke();
}

/**
 * Draw the number of events in place of a curve, where there is none.
 * @param {Scene} scene
 * @param {number[]} band
 */
function drawDensity({ c, g, colours }, band) {
  const counts = densityOf(band);
  const most = Math.max(...counts.map(([, count]) => count));
  const tall = 0.9 * (g.bottom - g.top);
  let end = counts[0][0];
  c.beginPath();
  c.moveTo(end, g.bottom);
  for (const [x, count] of counts) {
    if (x > end) {
      c.lineTo(end, g.bottom);
      c.lineTo(x, g.bottom);
    }
    end = x + BAND;
    const y = g.bottom - (tall * count) / most;
    c.lineTo(x, y);
    c.lineTo(end, y);
  }
  c.lineTo(end, g.bottom);
  c.fillStyle = colours.fill;
  c.fill();
  c.strokeStyle = colours.ahead;
  c.lineWidth = 1.5;
  c.stroke();
}

/**
 * Draw the score outside of the lane of each goal (without a score its label), the last goals first, and names and values of
 * the extremes of a series, where there is room; in a wide picture also the names of the goals.
 * @param {Scene} scene
 */
function drawLabels(scene) {
  const { c, g, view, info, hidden } = scene;
  c.font = fontOf(g, 600);
  c.textAlign = "center";
  c.textBaseline = "alphabetic";
  const isTall = g.bottom - g.top > LABELLED * g.em;
  /** @type {{ text: string, name: string, x: number, middle: number, half: number, line: number }[]} */
  const labels = [];
  /** @param {string} text */
  const halfOf = (text) => c.measureText(text).width / 2;
  /** @param {{ middle: number, half: number, line: number }} label */
  const hasRoom = (label, own = label) => 2 * label.half <= g.right - g.left && labels.every((one) => one === own
    || Math.abs(one.middle - label.middle) >= one.half + label.half + 4 || Math.abs(one.line - label.line) >= 14 * g.em);
  for (let i = view.events.length - 1; i >= 0; i -= 1) {
    const event = view.events[i];
    if (hidden.has(event.kind)) continue;
    const [x, y] = markPoint(g, view, info, event);
    const isExtreme = isTall && EXTREMES.has(event.kind) && event.value !== undefined;
    const text = isGoal(event) && !info.series ? event.score ?? (event.label || info.kinds[event.kind].name)
      : isExtreme ? `${event.kind === "highest" ? "Highest" : "Lowest"} ${valueText(event.value, { series: info.series && { ...info.series, unit: "" } })}` : "";
    if (!text) continue;
    const half = halfOf(text);
    const beside = x > (g.left + g.right) / 2 ? x - half - 14 : x + half + 14;
    const middle = Math.min(Math.max(isExtreme ? beside : x, half + 2), g.right - half);
    const outside = g.lanes.length > 1 && y === g.lanes[1] ? y + 13 + 9 * g.em : g.lanes[0] - 13;
    const line = isExtreme ? Math.min(Math.max(y + 4 * g.em, 11 * g.em), g.bottom - 10) : outside;
    const label = { text, name: event.score ? nameOf(event) : "", x, middle, half, line };
    if (hasRoom(label)) labels.push(label);
  }
  for (const label of labels) {
    if (g.width < TALL || !label.name) continue;
    const text = `${label.text} ${label.name}`;
    const half = halfOf(text);
    const named = { ...label, text, half, middle: Math.min(Math.max(label.x, half + 2), g.right - half) };
    if (hasRoom(named, label)) Object.assign(label, named);
  }
  for (const { text, middle, line } of labels) drawText(scene, text, middle, line, "ink");
}
