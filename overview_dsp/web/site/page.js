// The page: data, sound, hand and picture put together, and what a person does with them.

import { tellAbout } from "./about.js";
import { Frames } from "./frames.js";
import { Hand } from "./hand.js";
import { HostSound } from "./host_sound.js";
import { listenToKeys } from "./keys.js";
import { Picture } from "./picture.js";
import { Served } from "./served.js";
import { bindSettings, keepSettings, loadSettings } from "./settings.js";
import { Shown } from "./shown.js";
import { Slider } from "./slider.js";
import { Speech } from "./speech.js";
import { Strokes } from "./strokes.js";
import { listenToTouch } from "./touch.js";
import { Twist } from "./twist.js";
import { Motor } from "./vibration.js";
import { Walk } from "./walk.js";
import { partBetween } from "./windows.js";
import { eventPassed, eventText } from "./words.js";

const by = (id) => document.getElementById(id);

export class Page {
  constructor(data, sound) {
    this.data = data;
    this.info = data.info;
    this.sound = sound;
    this.atHost = sound instanceof HostSound;
    this.settings = loadSettings();
    this.hand = new Hand(
      new Strokes(sound.clock, (place, touching, sample) => sound.control(place, touching, sample)),
    );
    this.hand.cursor = () => (this.meters === null ? null : this.cursor);
    this.picture = new Picture(by("layer"), by("canvas"), this.info);
    this.slider = new Slider(by("slider"), by("clock"), by("event"));
    this.speech = new Speech();
    this.motor = new Motor();
    this.twist = new Twist(this.hand, this.settings.start);
    this.shown = new Shown({
      data, sound, hand: this.hand, picture: this.picture,
      onshow: () => this.wake(), onfault: (line) => this.fault(line),
    });
    this.walk = new Walk(this.hand, this.shown, this.speech, this.info);
    this.frames = new Frames(sound, () => this.draw(), (told) => this.take(told));
    this.served = null;
    this.meters = null;
    this.cursor = 0;
    this.begun = false;
  }

  async begin() {
    by("title").textContent = this.info.title;
    document.title = `${this.info.title}: overView`;
    document.documentElement.classList.toggle("host", this.atHost);
    this.apply();
    const { windows, duration_s, server } = this.info;
    const whole = [0, duration_s];
    const first = partBetween(windows, server?.window ?? whole);
    await this.shown.begin(first, this.atHost ? first : partBetween(windows, whole));
    this.listen();
    if (server) this.served = new Served(this, server);
    this.wake();
  }

  get view() {
    return this.shown.view;
  }

  get place() {
    return this.hand.place;
  }

  get moment() {
    return this.shown.moment;
  }

  get film() {
    return this.served?.film ?? null;
  }

  get bench() {
    return this.served?.bench ?? null;
  }

  fault(message) {
    by("fault").textContent = message;
  }

  // --- the hand ---------------------------------------------------------------------------------

  listen() {
    const element = by("slider");
    const { shown, walk } = this;
    const onfirst = () => this.start();
    listenToTouch(element, this.hand, {
      placeOf: (x) => this.picture.placeOf(x),
      onpinch: (factor, place) => shown.zoom(factor > 1 ? 1 : -1, place),
      onfirst,
    });
    const play = () => this.served?.play();
    listenToKeys(element, { walk, shown, play }, onfirst);
    element.addEventListener("wheel", (event) => {
      event.preventDefault();
      shown.wheel(event);
    }, { passive: false });
    this.hand.onchange = () => this.wake();
    by("twist").addEventListener("click", () => this.toggleTwist());
    by("in").addEventListener("click", () => shown.zoom(1));
    by("out").addEventListener("click", () => shown.zoom(-1));
    by("earlier").addEventListener("click", () => shown.beside(-1));
    by("later").addEventListener("click", () => shown.beside(1));
    by("settings").addEventListener("click", () => by("dialog").showModal());
    by("calibrate").addEventListener("click", () => this.calibrate());
    bindSettings(by("dialog").querySelector("form"), this.settings, () => this.apply());
    document.addEventListener("visibilitychange", () => {
      if (document.hidden && !this.twist.on) this.leave();
    });
    window.addEventListener("pagehide", () => this.leave());
    new ResizeObserver(() => {
      this.picture.resize();
      this.wake();
    }).observe(by("canvas"));
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
      this.picture.redraw();
      this.tellAbout();
      this.wake();
    });
  }

  /** In a touch, a key or a click. */
  start() {
    this.sound.start();
    if (!this.begun) {
      // not of the sound, which some browsers let run before a touch
      this.begun = true;
      navigator.serviceWorker?.ready.then(({ active }) => active?.postMessage("keep windows"));
    }
    by("hint").classList.add("gone");
    this.wake();
  }

  leave() {
    this.hand.releaseAll();
    this.motor.rest();
    this.speech.still();
  }

  async toggleTwist() {
    this.start();
    if (this.twist.on) this.twist.end();
    else {
      try {
        await this.twist.begin();
      } catch (error) {
        this.fault(error.message);
      }
    }
    by("twist").setAttribute("aria-pressed", String(this.twist.on));
  }

  calibrate() {
    this.settings.start = this.twist.calibrate();
    keepSettings(this.settings);
  }

  // --- how it is felt ---------------------------------------------------------------------------

  /** Go over to another preset: its sound at once, its friction's picture when it rests. */
  async feel(before, after, surface) {
    await this.sound.feel(before, after, surface ? this.view : null);
    this.data.preset = after;
    if (surface) this.shown.drawAgain();
  }

  apply() {
    const { felt, clicks, vibration, volume, speech, contrast, still } = this.settings;
    this.gain = 10 ** (volume / 20);
    this.sound.route(felt);
    this.sound.volume(clicks ? this.gain : 0, vibration ? this.gain : 0);
    if (!vibration || felt !== "motor") this.motor.rest();
    this.speech.on = speech;
    if (!speech) this.speech.still();
    document.documentElement.classList.toggle("contrast", contrast);
    this.picture.still = still;
    this.picture.resize();
    this.tellAbout();
    this.wake();
  }

  tellAbout() {
    tellAbout(by("about"), by("kinds"), this.info);
  }

  // --- every frame ------------------------------------------------------------------------------

  wake() {
    if (this.view !== null) this.frames.wake();
  }

  /** What the sound told of the disk. */
  take(told) {
    const before = this.cursor;
    this.meters = told;
    this.cursor = told.cursor;
    this.picture.trace.push(told.torque, told.struck);
    this.frames.rests(this.hand.holder === null && told.cursor < 1e-4 && told.envelope < 1e-4);
    const { events, struck } = this.view;
    const passed = this.atHost
      ? [eventPassed(this.view, before, this.cursor)]
      : told.struck.map(({ event }) => events[struck[event] ?? -1]);
    this.tell(passed.filter(Boolean), told.peakTactor);
  }

  /** What was struck or passed goes to the motor and, unless the keys hold, to speech. */
  tell(passed, peak) {
    const { felt, vibration } = this.settings;
    if (!this.atHost && felt === "motor" && vibration) {
      const codes = passed.map(({ kind }) => this.info.kinds[kind].pulse);
      this.motor.feel(codes, peak / this.gain, performance.now());
    }
    const last = passed.at(-1);
    if (last && this.hand.holder !== "keys") this.speech.say(eventText(last, this.info));
  }

  draw() {
    const touching = this.hand.holder !== null;
    this.picture.draw({ cursor: this.cursor, hand: this.place, touching });
    this.slider.show(this.view, this.place, this.cursor, this.info);
  }
}
