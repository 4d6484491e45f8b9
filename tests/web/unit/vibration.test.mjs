import assert from "node:assert/strict";
import { test } from "node:test";

import { Motor } from "../../../overview_dsp/web/site/vibration.js";

test("after a stop an event is not preceded by the rest of the one that was stopped", () => {
  const sent = [];
  const motor = new Motor((pattern) => sent.push(pattern), () => []);
  motor.play([[90, 30, 90]], 0.5, 0);
  motor.stop();
  motor.play([[40]], 0.5, 20);
  assert.deepEqual(sent, [[90, 30, 90], 0, [40]]);
});
