import assert from "node:assert/strict";
import test from "node:test";

globalThis.window = globalThis;
Object.defineProperty(globalThis, "navigator", { value: { languages: ["de-DE", "en"] } });
const { momentText, spokenMoment } = await import("../../../overview_dsp/web/site/descriptions.js");
const { linesOf, valueText } = await import("../../../overview_dsp/web/site/values.js");
const { ticksOf } = await import("../../../overview_dsp/web/site/ticks.js");

const INFO = { start: "2008-07-02T00:00:00", duration_s: 9e6, series: { decimals: 1, unit: "°C", has_times: false } };

test("dates and numbers are those of the reader's language", () => {
  assert.equal(spokenMoment(0, INFO), "2. Juli 2008");
  assert.equal(momentText(120 * 86400, INFO), "30. Okt. 2008");
  assert.equal(valueText(-1234.56, INFO), "\u22121234,6 °C");
  assert.equal(valueText(101325, INFO), "101.325,0 °C");
  assert.deepEqual(linesOf([0, 1], 2).map(({ text }) => text), ["0,0", "0,5", "1,0"]);
  const ticks = ticksOf({ start_s: 0, end_s: 9e6 }, INFO, (_, count) => count < 4);
  assert.deepEqual(ticks.map(({ text }) => text), ["Aug", "Sep", "Okt"]);
});
