import assert from "node:assert/strict";
import test from "node:test";
import { angleOf, geometryOf, isOnDial, positionTurned } from "../../../overview_dsp/web/site/geometry.js";

const PICTURES = [[320, 180], [375, 340], [390, 570], [421, 170], [667, 210], [844, 240], [768, 800], [1440, 650]]
  .flatMap(([width, height]) => [1, 1.5, 2].flatMap((em) => [0, 1, 2].flatMap((lanes) => [false, true].map((circular) =>
    ({ width, height, em, lanes, circular, still: false, figures: lanes ? 0 : 20 * em })))));
const LAID_OUT = PICTURES.map((picture) => [JSON.stringify(picture), geometryOf(picture)]);
const POSITIONS = Array.from({ length: 101 }, (_, i) => i / 100);

test("pixels and positions are inverse, and what lies beside the curve is at its end", () => {
  for (const [name, g] of LAID_OUT) {
    for (const position of POSITIONS) assert.ok(Math.abs(g.position(g.x(position)) - position) < 1e-9, name);
    assert.deepEqual([g.position(-1e4), g.position(1e4), g.x(0), g.x(1)], [0, 1, g.left, g.right]);
  }
});

test("the levels are between the top and the axis, with room for marks below the curve of a series", () => {
  for (const [name, g] of LAID_OUT) {
    const isSeries = JSON.parse(name).lanes === 0;
    assert.ok(isSeries ? g.y(0) < g.bottom : g.y(0) === g.bottom, name);
    assert.ok(g.y(1) > g.top && g.y(1) < g.y(0), name);
  }
});

test("curve, lane, groove, disk, labels and dial lie in the picture", () => {
  for (const [name, { left, right, top, bottom, em, width, height, radius, groove, lanes, dial }] of LAID_OUT) {
    assert.ok(left - radius >= 0 && right + radius <= width && right - left > 0.5 * width, name);
    assert.equal(lanes.length > 0, JSON.parse(name).lanes > 0, name);
    if (height > 400) assert.equal(lanes.length, JSON.parse(name).lanes, name);
    [0, ...lanes, top].reduce((before, y) => (assert.ok(y > before, name), y));
    assert.ok(bottom - top >= 30, name);
    assert.ok(groove - radius >= bottom && groove + radius + Math.round(18 * em) <= height + 6, name);
    if (dial) assert.ok(dial.y - dial.radius >= top && dial.y + dial.radius <= bottom, name);
  }
});

test("there is a dial only for a circular drag, and none with less motion", () => {
  for (const picture of PICTURES) {
    assert.equal(geometryOf(picture).dial !== null, picture.circular);
    assert.equal(geometryOf({ ...picture, still: true }).dial, null);
  }
});

test("a pointer on the dial leads to the position at its angle", () => {
  for (const [name, { dial }] of LAID_OUT) {
    if (!dial) continue;
    for (const position of POSITIONS.slice(1, -1)) {
      const x = dial.x + 0.8 * dial.radius * Math.cos(angleOf(position));
      const y = dial.y + 0.8 * dial.radius * Math.sin(angleOf(position));
      assert.ok(Math.abs(positionTurned(dial, x, y, 0) - position) < 1e-9, name);
    }
  }
});

test("a touch on the dial turns it, a touch on the groove does not", () => {
  for (const [name, g] of LAID_OUT) {
    if (g.dial) assert.ok(isOnDial(g, g.dial.x, g.dial.y - g.dial.radius), name);
    for (const position of POSITIONS) assert.ok(!isOnDial(g, g.x(position), g.groove + g.radius), name);
  }
});
