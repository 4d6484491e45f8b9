// jsPsych plugin for trials: presents stimuli, records one answer and shows optional feedback.

import { compare, detectYesNo, identify } from "./choose.js";
import { isCorrect, feedbackText } from "./feedback.js";
import { button, retryUntilDone, make } from "./make.js";
import { adjust, count, locate } from "./measure.js";
import { drawCurve } from "./sketch.js";
import { Stage } from "./stage.js";

export const VERSION = "0.1.0";
const CONTROLS = { identify, locate, search: locate, count, compare, adjust, draw: drawCurve };

const controlsOf = ({ task, method }) => CONTROLS[task] ?? (method === "yesno" ? detectYesNo : compare);

/**
 * Return the plugin of one session. `kit` has study, felt (the player), answers, twist, `say(line)` for
 * status messages, `fault(line)` for errors, `file(path)`, `progress()`, `preload(trial)` for the next
 * trial, and `leave()` for missing consent.
 */
export function trialPlugin(kit) {
  const { ParameterType } = /** @type {any} */ (globalThis).jsPsychModule;
  return class OverviewTrial {
    static info = {
      name: "overview-trial",
      version: VERSION,
      parameters: { trial: { type: ParameterType.OBJECT, default: undefined } },
      data: {
        response: { type: ParameterType.COMPLEX },
        correct: { type: ParameterType.BOOL },
        rt_ms: { type: ParameterType.FLOAT },
      },
    };

    async trial(display, { trial }, onLoad) {
      const screen = new TrialScreen(kit, display, trial);
      await screen.load();
      onLoad();
      const row = await screen.answered;
      await screen.store(row);
      if (trial.feedback) await screen.feedback(row);
      return { trial_id: trial.id, ...row };
    }
  };
}

class TrialScreen {
  constructor(kit, display, trial) {
    this.kit = kit;
    this.trial = trial;
    this.display = display;
    const { study } = kit;
    const { task } = study;
    const question = trial.attention === null
      ? task.question : `Please choose \u201c${task.words[trial.attention]}\u201d now.`;
    this.fault = (line) => kit.fault(line);
    this.stage = new Stage(kit, trial, this.fault);
    this.answered = new Promise((resolve) => {
      this.resolve = resolve;
    });
    this.controls = controlsOf(trial)({
      study, trial, stage: this.stage, label: question, fault: this.fault,
      say: (line) => kit.say(line), answer: (response) => this.answer(response),
    });
    this.question = make("h1", { id: "question", text: question });
    this.stage.onready = () => this.enable();
    this.started = new Date(); // set again once the stimuli are loaded
    this.onKey = (event) => this.key(event);
  }

  /** Load the stimuli and start the trial. */
  async load() {
    const { kit, stage, trial, display } = this;
    display.replaceChildren(make("p", { class: "note", text: "One moment\u2026" }));
    await retryUntilDone(async () => {
      await kit.felt.load(trial);
      if (stage.free) await stage.go(0);
    }, display, this.fault);
    kit.preload(trial);
    display.replaceChildren(this.question, stage.element, this.controls.element);
    this.started = new Date();
    await kit.felt.mask(trial.output.mask);
    document.addEventListener("keydown", this.onKey);
    stage.first.setAttribute("aria-describedby", "question");
    stage.first.focus({ preventScroll: true });
    window.scrollTo(0, 0);
    kit.progress();
    if (trial.attention !== null) this.enable();
  }

  /** Allow an answer from now on. */
  enable() {
    if (this.since !== undefined) return;
    this.since = performance.now();
    this.controls.enable();
  }

  key(event) {
    const { target, key, repeat, ctrlKey, altKey, metaKey } = event;
    if (repeat || ctrlKey || altKey || metaKey || target.matches?.("input, textarea, select")) return;
    if (this.since !== undefined && this.controls.key?.(key)) event.preventDefault();
  }

  /** Record the first answer; later answers are ignored. */
  answer(response) {
    if (this.since === undefined || this.row) return;
    const { kit, trial, stage, started } = this;
    const rt_ms = Math.round(1e3 * (performance.now() - this.since)) / 1e3;
    this.row = {
      response, correct: isCorrect(trial, response), rt_ms, started_utc: started.toISOString(),
      stimulus: trial.stimulus ?? null, level: trial.level ?? null, presentations: stage.count,
      source: stage.pad ? [...stage.pad.sources].join("+") || null : null,
      device: kit.felt.device, version: VERSION,
    };
    this.end(this.row).then(() => this.resolve(this.row), (error) => this.fault(error.message));
  }

  async end(row) {
    const { stage, kit } = this;
    document.removeEventListener("keydown", this.onKey);
    for (const one of this.display.querySelectorAll("button, input")) one.disabled = true;
    await stage.end();
    await kit.felt.mask(false);
    if (stage.pair) row.takes = stage.takes;
    else row.take = stage.takes[0] ?? null;
  }

  /** Store the answer in this browser, with retries. */
  store(row) {
    const { kit, trial, display } = this;
    return retryUntilDone(() => kit.answers.add(trial.id, row), display, this.fault, "Store it again");
  }

  /** Show the feedback until a button is pressed. */
  feedback({ response, correct }) {
    const line = feedbackText(this.trial, this.kit.study, response, correct);
    const next = make("div", { class: "feedback", "data-right": String(correct) }, make("p", { text: line }));
    this.display.replaceChildren(this.question, next);
    this.kit.say(line);
    return new Promise((resolve) => {
      const go = button("Next", resolve, { class: "done" });
      next.append(go);
      go.focus();
    });
  }
}
