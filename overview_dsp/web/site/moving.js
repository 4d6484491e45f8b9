// What moves: the cursor that sticks, the finger ahead of it, the disk and its two shafts.

import { angleOf } from "./geometry.js";
import { levelAt, resistanceAt } from "./layer.js";

/** `state`: cursor and hand (0 to 1), touching. */
export function drawMoving(c, g, view, state, info, colours) {
  const { cursor, hand, touching } = state;
  const x = g.x(cursor);
  const y = g.y(levelAt(view, cursor));
  const held = Math.log10(Math.max(1, resistanceAt(view, cursor) / info.bare_friction)) / 2;
  c.strokeStyle = colours.cursor;
  c.lineWidth = 2;
  c.beginPath();
  c.moveTo(x, g.top - 14);
  c.lineTo(x, g.bottom);
  c.stroke();
  if (touching) drawFinger(c, g, x, hand, colours);
  // as large as the friction under it
  dot(c, x, y, 6 + 9 * Math.min(held, 1), colours.cursor, 0.25);
  dot(c, x, y, 5, colours.cursor, 1);
  if (g.disk) drawDisk(c, g.disk, cursor, hand, touching, Math.min(held, 1), colours);
}

function drawFinger(c, g, x, hand, colours) {
  const to = g.x(hand);
  const y = g.top - 14;
  c.strokeStyle = colours.hand;
  c.lineWidth = 3;
  c.lineCap = "round";
  c.beginPath();
  c.moveTo(x, y);
  c.lineTo(to, y);
  c.stroke();
  dot(c, to, y, 8, colours.hand, 1);
}

function drawDisk(c, disk, cursor, hand, touching, held, colours) {
  const { x, y } = disk;
  const inner = disk.radius - 20;
  const phi = angleOf(cursor);
  c.lineCap = "round";
  // shaft 1, to the ground: always there
  c.strokeStyle = colours.curve;
  c.lineWidth = 2;
  c.beginPath();
  c.arc(x, y, disk.radius - 9, angleOf(0), phi);
  c.stroke();
  dot(c, x, y, inner, colours.disk, 1);
  // what it rubs on
  dot(c, x, y, inner * (0.16 + 0.3 * held), colours["disk-mark"], 0.28);
  c.strokeStyle = colours["disk-mark"];
  c.lineWidth = 4;
  c.beginPath();
  c.moveTo(x + inner * 0.62 * Math.cos(phi), y + inner * 0.62 * Math.sin(phi));
  c.lineTo(x + inner * 0.9 * Math.cos(phi), y + inner * 0.9 * Math.sin(phi));
  c.stroke();
  if (!touching) return;
  // shaft 2, to the finger: wound up by as much as the disk sticks
  const to = angleOf(hand);
  c.strokeStyle = colours.hand;
  c.lineWidth = 4;
  c.beginPath();
  c.arc(x, y, disk.radius, Math.min(phi, to), Math.max(phi, to));
  c.stroke();
  dot(c, x + disk.radius * Math.cos(to), y + disk.radius * Math.sin(to), 9, colours.hand, 1);
}

function dot(c, x, y, radius, colour, alpha) {
  c.globalAlpha = alpha;
  c.fillStyle = colour;
  c.beginPath();
  c.arc(x, y, radius, 0, 2 * Math.PI);
  c.fill();
  c.globalAlpha = 1;
}
