// An adaptive run: which trial comes next, from the answers so far. It holds no state of its own that
// the answers don't give again, so a page that was closed goes on where it was.

import { Quest } from "./quest.js";
import { Staircases } from "./staircase.js";

export class Run {
  /** `step`: an adaptive step of a list. */
  constructor(step) {
    this.step = step;
    this.rule = step.task === "quest" ? new Quest(step) : new Staircases(step);
    this.count = 0; // of answers
  }

  get over() {
    return this.count >= this.step.most || this.rule.over;
  }

  /** The trial that comes next, as a list's trials are. */
  next() {
    const { step, count } = this;
    const number = String(count + 1).padStart(3, "0");
    const absent = step.method === "yesno" && Boolean(step.catch[count]);
    const at = absent ? -1 : this.rule.next();
    const played = absent ? step.standard : step.stimuli[at];
    const side = step.sides?.[count] ?? 0;
    const pair = side === 0 ? [played, step.standard] : [step.standard, played];
    return {
      ...step, type: "trial", id: `${step.id}-${number}`, repeat: count + 1,
      phase: absent ? "catch" : step.phase,
      stimuli: step.method === "yesno" ? [played] : pair,
      correct: step.method === "yesno" ? Number(!absent) : side,
      stimulus: played, level: absent ? null : step.levels[at],
      feedback: step.feedback ?? false, criterion: null, attention: null,
    };
  }

  /** Its answer. */
  tell(response) {
    const { correct, phase } = this.next();
    this.count += 1;
    if (phase !== "catch") this.rule.tell(response === correct);
  }

  /** Take over the answers that are there: `answerOf(id)` is what is known of one, or undefined. */
  replay(answerOf) {
    while (!this.over) {
      const told = answerOf(this.next().id);
      if (told === undefined) return;
      this.tell(told.response);
    }
  }
}
