import assert from "node:assert/strict";
import test from "node:test";
import { Curve } from "../../overview_studies/page/curve.js";
import { isCorrect, feedbackText } from "../../overview_studies/page/feedback.js";
import { isWanted, planOf, progressOf } from "../../overview_studies/page/plan.js";

const trial = (id, phase, block) =>
  ({ id, type: "trial", phase, block, criterion: phase === "practice" ? 0.8 : null });
const STEPS = [
  { id: "b0-form-1-consent", type: "form", block: 0 },
  { id: "b1-instructions", type: "instructions", block: 1 },
  trial("b1-p1", "practice", 1), trial("b1-p2", "practice", 1),
  trial("b1-001", "main", 1), trial("b1-002", "main", 1),
  { id: "b1-form-1-tlx", type: "form", block: 1 },
  { id: "b2-break", type: "break", block: 2 },
  { id: "b2-instructions", type: "instructions", block: 2 },
  trial("b2-p1", "practice", 2), trial("b2-001", "main", 2),
  { id: "b2-form-1-tlx", type: "form", block: 2 },
];

const answered = (...ids) => new Map(ids.map((id) => [id, { response: 1, correct: true }]));
const names = (plan) => plan.map(({ screen, trial: asked, practice, run }) =>
  screen?.id ?? asked?.id ?? run?.step.id ?? practice[0].map(({ id }) => id).join("+"));

test("a new session has everything in its order", () => {
  assert.deepEqual(names(planOf(STEPS, answered())), [
    "b0-form-1-consent", "b1-instructions", "b1-p1+b1-p2", "b1-001", "b1-002", "b1-form-1-tlx",
    "b2-break", "b2-instructions", "b2-p1", "b2-001", "b2-form-1-tlx",
  ]);
  assert.deepEqual(progressOf(STEPS, answered()), { done: 0, total: 9 });
  assert.equal(progressOf(STEPS, answered("b1-p1", "b1-p1-2")).done, 1);
});

test("a page that is opened again says what to do and asks for what is left", () => {
  const first = ["b0-form-1-consent", "b1-p1", "b1-p2", "b1-001"];
  assert.deepEqual(names(planOf(STEPS, answered(...first))), [
    "b1-instructions", "b1-002", "b1-form-1-tlx", "b2-break", "b2-instructions", "b2-p1", "b2-001",
    "b2-form-1-tlx",
  ]);
  const whole = [...first, "b1-002", "b1-form-1-tlx"];
  assert.equal(names(planOf(STEPS, answered(...whole)))[0], "b2-break");
  assert.deepEqual(names(planOf(STEPS, answered(...whole, "b2-p1"))),
    ["b2-instructions", "b2-001", "b2-form-1-tlx"]);
  assert.deepEqual(planOf(STEPS, answered(...STEPS.map(({ id }) => id))), []);
});

test("practice is repeated while too few are right, at most twice, and never once trials began", () => {
  const [{ practice }] = planOf(STEPS.slice(2, 4), answered());
  assert.deepEqual(practice.map((round) => round.map(({ id }) => id)),
    [["b1-p1", "b1-p2"], ["b1-p1-2", "b1-p2-2"], ["b1-p1-3", "b1-p2-3"]]);
  const wrong = (...ids) => new Map(ids.map((id) => [id, { response: 1, correct: false }]));
  assert.equal(isWanted(practice, 1, answered("b1-p1", "b1-p2")), false);
  assert.equal(isWanted(practice, 1, wrong("b1-p1")), false); // not yet
  assert.equal(isWanted(practice, 1, wrong("b1-p1", "b1-p2")), true);
  const strict = practice.map((round) => round.map((one) => ({ ...one, criterion: 1 })));
  assert.equal(isWanted(strict, 1, answered("b1-p1", "b1-p2")), false); // all right is enough
  const twice = ["b1-p1", "b1-p2", "b1-p1-2", "b1-p2-2"];
  assert.equal(isWanted(practice, 2, wrong(...twice)), true);
  const rounds = [...twice, "b1-p1-3", "b1-p2-3"];
  assert.equal(names(planOf(STEPS, wrong("b0-form-1-consent", ...twice)))[1], "b1-p1+b1-p2");
  assert.equal(names(planOf(STEPS, wrong("b0-form-1-consent", ...rounds)))[1], "b1-001");
  const begun = new Map([...wrong("b0-form-1-consent", "b1-p1", "b1-p2"), ...answered("b1-001")]);
  assert.equal(names(planOf(STEPS, begun))[1], "b1-002");
});

test("right is what the list says, where that can be said", () => {
  assert.equal(isCorrect({ task: "identify", correct: "goal" }, "goal"), true);
  assert.equal(isCorrect({ task: "count", correct: 3 }, 2), false);
  assert.equal(isCorrect({ task: "compare", correct: null }, 1), null);
  assert.equal(isCorrect({ task: "locate", correct: [0.4] }, 0.4), null);
  const study = { task: { words: { goal: "a goal", foul: "a foul" } } };
  const asked = { task: "identify", correct: "goal" };
  assert.equal(feedbackText(asked, study, "foul", false), "Your answer: a foul. Correct: a goal.");
  assert.equal(feedbackText({ task: "locate", correct: [0.4] }, study, 0.5, null),
    "Your answer: 50 %. Correct: 40 %.");
});

test("a curve follows the pen between the places it was seen at, and its handles", () => {
  const curve = new Curve();
  assert.equal(curve.response, null);
  curve.begin(0, 0);
  curve.move(1, 1);
  assert.equal(curve.response.length, 64);
  assert.deepEqual([0, 21, 63].map((i) => curve.response[i]), [0, 0.333, 1]);
  curve.move(0.5, 0); // and back
  assert.ok(curve.response[63] === 1 && curve.response[32] === 0 && curve.response[0] === 0);
  curve.clear();
  curve.setHandle(0, 0.8);
  assert.equal(curve.response[0], 0.8);
  assert.equal(curve.response[2], 0.4);
  assert.equal(curve.response[4], 0);
});
