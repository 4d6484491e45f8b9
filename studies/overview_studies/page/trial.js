// A trial as a jsPsych plugin: it presents, waits for one answer, keeps it, and says whether it was
// right where the list asks for that.

import { compare, detect, identify } from "./choose.js";
import { judged, told } from "./judging.js";
import { button, insisted, make } from "./make.js";
import { adjust, count, locate } from "./measure.js";
import { sketch } from "./sketch.js";
import { Stage } from "./stage.js";

export const VERSION = "0.1.0";
const CONTROLS = { identify, locate, count, compare, adjust, draw: sketch };

const controlsOf = ({ task, method }) => CONTROLS[task] ?? (method === "yesno" ? detect : compare);

/**
 * The plugin for one session. `kit`: study, felt, answers, twist, `say(line)` to whoever listens,
 * `fault(line)`, `file(path)`, `progress()`, `ahead(trial)` fetches what comes next, `leave()` ends without consent.
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
      const asked = new Asked(kit, display, trial);
      await asked.load();
      onLoad();
      const row = await asked.answered;
      await asked.keep(row);
      if (trial.feedback) await asked.feedback(row);
      return { trial_id: trial.id, ...row };
    }
  };
}

class Asked {
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
    this.heard = (event) => this.key(event);
  }

  /** Fetch what is presented; the trial begins. */
  async load() {
    const { kit, stage, trial, display } = this;
    display.replaceChildren(make("p", { class: "note", text: "One moment\u2026" }));
    await insisted(async () => {
      await kit.felt.load(trial);
      if (stage.free) await stage.go(0);
    }, display, this.fault);
    kit.ahead(trial);
    display.replaceChildren(this.question, stage.element, this.controls.element);
    this.started = new Date();
    await kit.felt.mask(trial.output.mask);
    document.addEventListener("keydown", this.heard);
    stage.first.setAttribute("aria-describedby", "question");
    stage.first.focus({ preventScroll: true });
    window.scrollTo(0, 0);
    kit.progress();
    if (trial.attention !== null) this.enable();
  }

  /** It can be answered from now on. */
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

  /** The first answer counts, no second. */
  answer(response) {
    if (this.since === undefined || this.row) return;
    const { kit, trial, stage, started } = this;
    const rt_ms = Math.round(1e3 * (performance.now() - this.since)) / 1e3;
    this.row = {
      response, correct: judged(trial, response), rt_ms, started_utc: started.toISOString(),
      stimulus: trial.stimulus ?? null, level: trial.level ?? null, presentations: stage.count,
      source: stage.free ? [...stage.pad.sources].join("+") || null : null,
      device: kit.felt.device, version: VERSION,
    };
    this.end().then(() => this.resolve(this.row), (error) => this.fault(error.message));
  }

  async end() {
    const { stage, kit } = this;
    document.removeEventListener("keydown", this.heard);
    for (const one of this.display.querySelectorAll("button, input")) one.disabled = true;
    await stage.end();
    await kit.felt.mask(false);
    if (stage.pair) this.row.takes = stage.takes;
    else this.row.take = stage.takes[0] ?? null;
  }

  /** The answer on this browser's disk, whatever that takes. */
  keep(row) {
    const { kit, trial, display } = this;
    return insisted(() => kit.answers.add(trial.id, row), display, this.fault, "Keep it again");
  }

  /** Say how it was, and wait until that is read. */
  feedback({ response, correct }) {
    const line = told(this.trial, this.kit.study, response, correct);
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
