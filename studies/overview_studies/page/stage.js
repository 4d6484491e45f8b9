// Presentation of a trial: one or two stimuli, played on request or explored freely, with their takes.

import { legendOf, View } from "./drawing.js";
import { button, make, pause } from "./make.js";
import { Pad } from "./pad.js";

const GAP_MS = 500; // between two intervals
const NAMES = ["first", "second"]; // of a pair's stimuli

export class Stage {
  /**
   * `onready()` is called when all stimuli were explored or played, `onfault(line)` on errors.
   */
  constructor({ study, felt, twist }, trial, onfault) {
    this.study = study;
    this.felt = felt;
    this.twist = twist;
    this.trial = trial;
    this.stimuli = [...trial.stimuli];
    this.onfault = onfault;
    this.onready = () => {};
    this.free = study.stimuli[this.stimuli[0]].events === null;
    this.present = null; // the current presentation
    this.at = 0; // index of its stimulus
    this.count = 0; // number of presentations
    this.known = new Set(); // indexes of presented stimuli
    this.takes = [];
    this.pad = null; // of free exploration
    this.buttons = []; // that play
    this.lamp = make("p", { class: "lamp", "aria-hidden": "true", text: "\u00a0" });
    this.element = make("div", { class: "stage" });
    if (this.free) this.buildFree();
    else this.buildPlayed();
    if (trial.output.visual) this.element.append(legendOf(study.kinds));
  }

  get pair() {
    return this.stimuli.length > 1;
  }

  /** Element that gets the focus first. */
  get first() {
    return this.pad?.slider ?? this.element.querySelector("button");
  }

  // --- free exploration -------------------------------------------------------------------------

  buildFree() {
    const { trial, study } = this;
    this.pad = new Pad({
      input: trial.output.input, label: "Field to feel", kinds: study.kinds, twist: this.twist,
      onfault: this.onfault,
    });
    this.pad.ontouched = () => this.markTouched();
    if (this.pair) {
      this.tabs = NAMES.map((name, i) =>
        button(`Feel the ${name}`, () => this.choose(i), { "aria-pressed": i === 0 }));
      this.element.append(make("div", { class: "tabs", role: "group", "aria-label": "Which one" },
        ...this.tabs));
    }
    this.element.append(this.pad.element);
  }

  choose(number) {
    this.go(number).catch((error) => this.onfault(error.message));
  }

  /** Connect a stimulus to the pad. */
  async go(number) {
    this.going = number;
    this.tabs?.forEach((tab, i) => tab.setAttribute("aria-pressed", String(i === number)));
    await this.stop();
    const key = this.stimuli[number];
    const { output } = this.trial;
    const presentation = await this.open(key, null);
    const view = output.visual ? await this.felt.drawn(key) : null;
    if (this.going !== number || this.ended) {
      presentation.stop(); // the participant selected the other one
      return;
    }
    this.at = number;
    this.present = presentation;
    this.pad?.begin(presentation, view);
  }

  markTouched() {
    this.felt.start().catch((error) => this.onfault(error.message));
    this.count += 1;
    this.know(this.at);
  }

  // --- played -----------------------------------------------------------------------------------

  buildPlayed() {
    const { trial } = this;
    const act = (numbers) => () => this.play(numbers);
    const separate = trial.task === "adjust";
    this.buttons = separate
      ? NAMES.map((name, i) => button(`Play the ${name}`, act([i])))
      : [button("Play", act(this.stimuli.map((_, i) => i)), { class: "play" })];
    this.element.append(make("div", { class: "tabs" }, ...this.buttons));
    this.view = trial.output.visual ? new View(this.study.kinds) : null;
    if (this.view) this.element.append(make("div", { class: "pad seen" }, this.view.element));
    this.element.append(this.lamp);
  }

  async play(numbers) {
    if (this.playing) return;
    this.playing = true;
    // the buttons stay focusable for keyboard users
    this.buttons.forEach((one) => one.setAttribute("aria-disabled", "true"));
    try {
      await this.felt.start();
      for (const number of numbers) {
        if (number !== numbers[0]) await pause(GAP_MS);
        if (this.ended) return;
        this.lamp.textContent = this.pair ? NAMES[number] : "playing";
        const key = this.stimuli[number];
        this.present = await this.open(key, this.study.stimuli[key].events);
        this.view?.show(await this.felt.drawn(key));
        const { duration_s } = this.study.stimuli[key];
        const whole = await this.present.rested(duration_s, ({ cursor }) => this.view?.at(cursor));
        this.present.stop();
        this.lamp.textContent = "\u00a0";
        if (!whole) return;
        this.know(number);
      }
      this.count += 1;
    } catch (error) {
      this.onfault(error.message);
    } finally {
      this.playing = false;
      this.buttons.forEach((one) => one.removeAttribute("aria-disabled"));
    }
  }

  // --- both -------------------------------------------------------------------------------------

  async open(key, events) {
    const presentation = await this.felt.open(key, this.trial.output, events);
    presentation.onfault = this.onfault;
    return presentation;
  }

  know(number) {
    this.known.add(number);
    if (this.known.size === this.stimuli.length) this.onready();
  }

  /** Replace the second stimulus of a pair, from its next presentation on. */
  replace(key) {
    this.stimuli[1] = key;
    if (this.free && this.at === 1) return this.go(1);
    return Promise.resolve();
  }

  /** Stop the presentation and store its take. */
  async stop() {
    const { present, pad } = this;
    if (present === null || present.stopped) return;
    pad?.release();
    const stimulus = this.stimuli[this.at];
    if (pad?.touched) this.takes.push({ stimulus, ...(await present.take()) });
    present.stop();
  }

  /** End all presentations. */
  async end() {
    this.ended = true;
    await this.stop();
    this.pad?.end();
    this.view?.end();
  }
}
