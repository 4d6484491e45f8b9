import assert from "node:assert/strict";
import test from "node:test";
import { croppedMap, positionAt, secondsAt } from "../../../overview_dsp/web/site/angle_map.js";

/** A view with a map of `count` parts that are stretched or compressed up to 20 times. */
function someView(count) {
  const shares = Array.from({ length: count }, (_, i) => 1 + ((i * 7) % 20));
  const sum = shares.reduce((a, b) => a + b, 0);
  let before = 0;
  const position = [0, ...shares.map((share) => (before += share) / sum)];
  const time_s = position.map((_, i) => 100 + (900 * i) / count);
  return { start_s: 100, end_s: 1000, angle_map: { time_s, position } };
}

const VIEWS = [{ start_s: 100, end_s: 1000, angle_map: null }, { start_s: 100, end_s: 1000 }, ...[1, 2, 9, 60].map(someView)];
const POSITIONS = Array.from({ length: 301 }, (_, i) => i / 300);

for (const view of VIEWS) {
  const name = view.angle_map ? `${view.angle_map.time_s.length - 1} parts` : "no map";

  test(`position and time are inverse with ${name}`, () => {
    for (const position of POSITIONS) {
      const moment = secondsAt(view, position);
      assert.ok(moment >= 100 && moment <= 1000);
      assert.ok(Math.abs(positionAt(view, moment) - position) < 1e-9, `${position}`);
    }
  });

  test(`time rises from start to end, and what lies outside is at an end, with ${name}`, () => {
    const moments = POSITIONS.map((position) => secondsAt(view, position));
    assert.ok(moments.every((moment, i) => i === 0 || moment > moments[i - 1]));
    assert.deepEqual([moments[0], moments.at(-1)], [100, 1000]);
    assert.deepEqual([positionAt(view, -1e9), positionAt(view, 1e9)], [0, 1]);
  });
}

test("a cropped map gives the same times", () => {
  for (const view of VIEWS.filter(({ angle_map: map }) => map)) {
    for (const [from, to] of [[0, 1], [0.2, 0.3], [0.05, 0.95], [0.5, 1]]) {
      const part = {
        start_s: secondsAt(view, from), end_s: secondsAt(view, to), angle_map: croppedMap(view, from, to),
      };
      for (const position of POSITIONS) {
        const wanted = secondsAt(view, from + (to - from) * position);
        assert.ok(Math.abs(secondsAt(part, position) - wanted) < 1e-6, `${from} ${to} ${position}`);
      }
    }
  }
  assert.equal(croppedMap(VIEWS[0], 0.2, 0.3), null);
});
