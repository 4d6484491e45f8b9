import assert from "node:assert/strict";
import test from "node:test";
import { scoreAt } from "../../../overview_dsp/web/site/descriptions.js";
import { markOf } from "../../../overview_dsp/web/site/marks.js";
import { copyScores, nameOf, readableTitle, setScores, titleParts } from "../../../overview_dsp/web/site/scores.js";

/** @type {(labels: string[], kind?: string) => any[]} */
const eventsOf = (labels, kind = "goal") => labels.map((label, i) => ({ kind, label, time_s: 60 * i, position: i / 10 }));
/** @type {(scores: (string | undefined)[]) => any[]} */
const goalsOf = (scores) => eventsOf(scores.map(() => "")).map((goal, i) => ({ ...goal, score: scores[i] }));

test("the side of a goal is that of the score that it changes", () => {
  const events = goalsOf([undefined, "1-0", "1-1", undefined, "2-1", "2-1", "2-2"]);
  setScores(events);
  assert.deepEqual(events.map(({ side }) => side), [undefined, 1, 2, undefined, 1, undefined, 2]);
  assert.equal(events[6].score, "2\u20132");
});

test("a score is written with a dash, and cards keep their sides", () => {
  const goals = goalsOf(["1-0", "1-1", "2-1"]).map((goal, i) => ({ ...goal, side: [1, 2, 1][i] }));
  const events = [...goals, ...eventsOf(["card"], "yellow_card").map((card) => ({ ...card, side: 2 }))];
  setScores(events);
  assert.deepEqual(events.map(({ score }) => score), ["1\u20130", "1\u20131", "2\u20131", undefined]);
  assert.deepEqual(events.map(({ side }) => side), [1, 2, 1, 2]);
});

test("the name of a goal is its label without its own score", () => {
  assert.equal(nameOf({ label: "1-1 Perišić", score: "1\u20131" }), "Perišić");
  assert.equal(nameOf({ label: "1-0 Perišić", score: "1\u20131" }), "1-0 Perišić");
  assert.equal(nameOf({ label: "1-1", score: "1\u20131" }), "1-1");
  assert.equal(nameOf({ label: "Kanté (France)", score: undefined }), "Kanté (France)");
});

test("the title of a match has its teams, what is between them, and what follows", () => {
  const sides = ["France", "Croatia"];
  const parts = (title) => titleParts({ title, sides });
  assert.deepEqual(parts("France 4-2 Croatia, final"), { one: "France", two: "Croatia", between: " 4-2 ", rest: "final" });
  assert.equal(parts("France v Croatia")?.rest, "");
  assert.equal(parts("The final"), null);
  assert.equal(titleParts({ title: "France", sides: [] }), null);
});

test("a card keeps its colour and has the rim of its team", () => {
  assert.deepEqual(markOf("yellow_card", { shape: "card" }, 2), { shape: "card", colour: "card", rim: "two", isRing: false });
  assert.deepEqual(markOf("foul", { shape: "cross" }, 1), { shape: "cross", colour: "one", isRing: false });
});

test("a label is no score", () => {
  const events = [...eventsOf(["12-15 year olds", "1-0"], "note"), ...eventsOf(["1-0 Jones"])];
  setScores(events);
  assert.deepEqual(events.map(({ score }) => score), [undefined, undefined, undefined]);
});

test("a window has the sides and the score of the whole timeline", () => {
  const whole = goalsOf(["1-0", "2-0", "2-1", "3-1"]);
  setScores(whole);
  const view = /** @type {any} */ ({
    start_s: 100, tolerance: 0,
    events: goalsOf(["1-0", "2-0", "0-1", "1-1"]).slice(2) // as counted within the window
      .map((event, i) => ({ ...event, time_s: event.time_s + 1e-9, position: 0.2 + 0.4 * i })),
  });
  copyScores(view, whole);
  assert.deepEqual(view.events.map(({ side }) => side), [2, 1]);
  assert.deepEqual([0, 0.3, 0.7].map((position) => scoreAt(view, position)), ["2\u20130", "2\u20131", "3\u20131"]);
});

test("a title that begins with a file's name is in words", () => {
  assert.equal(readableTitle("bokeh_AAPL: Adj Close"), "bokeh AAPL: Adj Close");
  assert.equal(readableTitle("seattle-weather-hourly-normals: temperature"), "seattle weather hourly normals: temperature");
  assert.equal(readableTitle("sp500-2000: open_price"), "sp500-2000: open_price");
  assert.equal(readableTitle("run_2020-01-31"), "run_2020-01-31");
});

test("a title in words stays as it is", () => {
  for (const title of ["Saint-\u00c9tienne 2-1 Lyon, final", "World Cup final", "Orchard, share_price: x"]) {
    assert.equal(readableTitle(title), title);
  }
});
