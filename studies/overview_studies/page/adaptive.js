// Adaptive run: chooses the next trial from the answers so far. The answers determine its state, so a
// reloaded page resumes the run.

import { Quest } from "./quest.js";
import { Staircases } from "./staircase.js";

export class Run {
  /** `step`: an adaptive step of a list. */
  constructor(step) {
    this.step = step;
    this.rule = step.task === "quest" ? new Quest(step) : new Staircases(step);
    this.count = 0; // number of answers
  }

  get over() {
    return this.count >= this.step.most || this.rule.over;
  }

  /** Return the next trial in the format of a list's trials. */
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

  /** Record the answer to the next trial. */
  addResponse(response) {
    const { correct, phase } = this.next();
    this.count += 1;
    if (phase !== "catch") this.rule.addResponse(response === correct);
  }

  /** Record the stored answers; `answerOf(id)` returns an answer or undefined. */
  replay(answerOf) {
    while (!this.over) {
      const stored = answerOf(this.next().id);
      if (stored === undefined) return;
      this.addResponse(stored.response);
    }
  }
}
