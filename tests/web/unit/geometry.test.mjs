import assert from "node:assert/strict";
import test from "node:test";
import { angleOf, geometryOf, isOnDisk, positionTurned } from "../../../overview_dsp/web/site/geometry.js";

const PICTURES = [[320, 270], [375, 340], [390, 570], [568, 170], [667, 210], [844, 240], [768, 800], [1440, 650]]
  .flatMap(([width, height]) => [1, 1.5, 2].flatMap((em) => [false, true].map((still) =>
    ({ width, height, short: Math.min(width, height + 200), em, still }))));
const LAID_OUT = PICTURES.map((picture) => [JSON.stringify(picture), geometryOf(picture)]);
const POSITIONS = Array.from({ length: 101 }, (_, i) => i / 100);

test("pixels and positions are inverse, and what lies beside the curve is at its end", () => {
  for (const [name, g] of LAID_OUT) {
    for (const position of POSITIONS) assert.ok(Math.abs(g.position(g.x(position)) - position) < 1e-9, name);
    assert.deepEqual([g.position(-1e4), g.position(1e4), g.x(0), g.x(1)], [0, 1, g.left, g.right]);
  }
});

test("the lowest level is at the axis, and the highest is below the top", () => {
  for (const [name, g] of LAID_OUT) {
    assert.equal(g.y(0), g.bottom, name);
    assert.ok(g.y(1) > g.top && g.y(1) < g.bottom, name);
  }
});

test("curve, axis, disk and trace lie in the picture", () => {
  for (const [name, { left, right, top, bottom, axis, width, height, disk, trace }] of LAID_OUT) {
    assert.ok(left >= 0 && right <= width && right - left > 0.3 * width, name);
    assert.ok(top >= 0 && bottom + axis <= height && bottom > top, name);
    if (disk) assert.ok(disk.x - disk.radius >= 0 && disk.x + disk.radius <= width, name);
    if (trace) {
      assert.ok(trace.y - trace.half > bottom + axis && trace.y + trace.half <= height, name);
      assert.ok(trace.left >= left && trace.right <= right, name);
    }
  }
});

test("less motion leaves out disk and trace, and gives their place to the curve", () => {
  for (const picture of PICTURES.filter(({ still }) => !still)) {
    const [moving, still] = [geometryOf(picture), geometryOf({ ...picture, still: true })];
    assert.deepEqual([still.disk, still.trace], [null, null]);
    assert.ok(moving.disk !== null);
    assert.ok(still.right >= moving.right && still.bottom >= moving.bottom);
  }
});

test("a pointer on the disk leads to the position at its angle", () => {
  for (const [name, { disk }] of LAID_OUT) {
    if (!disk) continue;
    for (const position of POSITIONS.slice(1, -1)) {
      const x = disk.x + 0.8 * disk.radius * Math.cos(angleOf(position));
      const y = disk.y + 0.8 * disk.radius * Math.sin(angleOf(position));
      assert.ok(Math.abs(positionTurned(disk, x, y, 0) - position) < 1e-9, name);
    }
  }
});

test("a touch on the disk turns it, a touch on the curve does not", () => {
  for (const [name, g] of LAID_OUT) {
    if (g.disk) assert.ok(isOnDisk(g, g.disk.x, g.disk.y - g.disk.radius), name);
    for (const position of POSITIONS) assert.ok(!isOnDisk(g, g.x(position), (g.top + g.bottom) / 2), name);
  }
});
