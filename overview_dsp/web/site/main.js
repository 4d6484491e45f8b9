// The page: data, sound, hand and picture put together.

import { Data } from "./data.js";
import { Hand } from "./hand.js";
import { listenToKeys } from "./keys.js";
import { drawMark } from "./marks.js";
import { keepOffline } from "./offline.js";
import { coloursOf, Picture } from "./picture.js";
import { bindSettings, keepSettings, loadSettings } from "./settings.js";
import { Slider } from "./slider.js";
import { Sound } from "./sound.js";
import { Speech } from "./speech.js";
import { Strokes } from "./strokes.js";
import { listenToTouch } from "./touch.js";
import { Twist } from "./twist.js";
import { Motor } from "./vibration.js";
import { eventText, momentText, placeText, secondsAt } from "./words.js";
import { levels, windowAbout, windowBeside } from "./windows.js";

const QUIET_FRAMES = 40; // after which an unheld disk at rest is looked at no more

const by = (id) => document.getElementById(id);

class Page {
  constructor(data, sound) {
    this.data = data;
    this.info = data.info;
    this.sound = sound;
    this.settings = loadSettings();
    this.hand = new Hand(
      new Strokes(sound.clock, (place, touching, sample) => sound.control(place, touching, sample)),
    );
    this.picture = new Picture(by("canvas"), this.info);
    this.slider = new Slider(by("slider"), by("clock"), by("event"));
    this.speech = new Speech();
    this.motor = new Motor();
    this.twist = new Twist(this.hand, this.settings.start);
    this.meters = null;
    this.cursor = 0;
    this.quiet = 0;
    this.running = false;
    this.view = null;
  }

  async begin() {
    by("title").textContent = this.info.title;
    document.title = `${this.info.title}: overView`;
    this.tellAbout();
    this.apply();
    await this.go(0);
    this.listen();
    this.wake();
  }

  // --- the hand ---------------------------------------------------------------------------------

  listen() {
    const element = by("slider");
    const onfirst = () => this.start();
    listenToTouch(element, this.hand, {
      placeOf: (x) => this.picture.placeOf(x),
      onpinch: (factor, place) => this.zoom(factor > 1 ? 1 : -1, place),
      onfirst,
    });
    listenToKeys(element, this, onfirst);
    element.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.wheel(event);
    }, { passive: false });
    this.hand.onchange = () => this.wake();
    by("twist").addEventListener("click", () => this.toggleTwist());
    by("in").addEventListener("click", () => this.zoom(1));
    by("out").addEventListener("click", () => this.zoom(-1));
    by("earlier").addEventListener("click", () => this.beside(-1));
    by("later").addEventListener("click", () => this.beside(1));
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
    if (!this.sound.running) {
      this.sound.start();
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

  get place() {
    return this.hand.place;
  }

  move(by_) {
    const wanted = this.place + by_;
    const side = Math.sign(by_);
    if ((wanted > 1 && this.place === 1) || (wanted < 0 && this.place === 0)) this.beside(side);
    else this.to(wanted);
  }

  to(place) {
    this.hand.hold("keys", place);
    this.sayPlace();
  }

  tap() {
    this.hand.tap("keys", this.place);
    this.sayPlace();
  }

  letGo() {
    this.hand.release("keys");
  }

  /** To the next (1) or the last (-1) event, in this window or beyond its end. */
  async event(direction) {
    const near = 1e-6;
    const after = (event) => (event.place - this.place) * direction > near;
    let found = this.view.events.filter(after);
    if (found.length === 0) {
      const now = this.moment;
      if (!(await this.beside(direction))) return;
      found = this.view.events.filter((event) => (event.time_s - now) * direction > near);
    }
    const next = direction > 0 ? found[0] : found.at(-1);
    if (next) this.to(next.place);
  }

  sayPlace() {
    this.speech.say(placeText(this.view, this.place, this.info));
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

  // --- windows ----------------------------------------------------------------------------------

  get moment() {
    return secondsAt(this.view, this.place);
  }

  zoom(direction, place = this.place) {
    const { windows } = this.info;
    const level = Math.min(Math.max(this.view.zoom + direction, 0), levels(windows));
    if (level === this.view.zoom) return Promise.resolve(false);
    return this.go(windowAbout(windows, level, secondsAt(this.view, place)));
  }

  beside(direction) {
    const next = windowBeside(this.info.windows, this.view.number, direction);
    return next < 0 ? Promise.resolve(false) : this.go(next);
  }

  wheel({ deltaX, deltaY, shiftKey, clientX }) {
    const now = performance.now();
    const along = Math.abs(deltaX) > Math.abs(deltaY) || shiftKey;
    this.turned = now - (this.wheeled ?? 0) > 250 ? 0 : this.turned;
    this.wheeled = now;
    this.turned += along ? deltaX || deltaY : deltaY;
    if (Math.abs(this.turned) < 60) return;
    const direction = Math.sign(this.turned);
    this.turned = 0;
    if (along) this.beside(direction);
    else this.zoom(-direction, this.picture.placeOf(clientX));
  }

  /** Put window `i` under the hand; the moment a key holds stays under it. */
  async go(i) {
    if (this.going) return false;
    this.going = true;
    try {
      const first = this.view === null;
      const { context } = this.sound;
      const [view, bytes] = await Promise.all([
        this.data.view(i), first ? null : this.data.change(i, context.sampleRate),
      ]);
      const moment = first ? 0 : this.moment;
      if (bytes) this.sound.change(bytes);
      this.view = view;
      this.picture.show(view);
      if (this.hand.holder === "keys") {
        this.hand.hold("keys", (moment - view.start_s) / (view.end_s - view.start_s));
      }
      this.tellWindow();
      this.wake();
      return true;
    } catch (error) {
      this.fault(error.message);
      return false;
    } finally {
      this.going = false;
    }
  }

  tellWindow() {
    const { windows } = this.info;
    const { number, zoom: level, start_s: start, end_s: end } = this.view;
    by("window").textContent = `${momentText(start, this.info)} to ${momentText(end, this.info)}`;
    by("in").disabled = level >= levels(windows);
    by("out").disabled = level === 0;
    by("earlier").hidden = by("later").hidden = level === 0;
    by("earlier").disabled = windowBeside(windows, number, -1) < 0;
    by("later").disabled = windowBeside(windows, number, 1) < 0;
  }

  // --- settings ---------------------------------------------------------------------------------

  apply() {
    const { felt, clicks, vibration, volume, speech, contrast, still } = this.settings;
    const gain = 10 ** (volume / 20);
    this.sound.route(felt);
    this.sound.volume(clicks ? gain : 0, vibration ? gain : 0);
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
    by("about").textContent = [this.info.provenance, ...this.info.notes].filter(Boolean).join(". ");
    const colours = coloursOf(document.documentElement);
    by("kinds").replaceChildren(
      ...Object.values(this.info.kinds).map(({ words, shape, colour, count }) => {
        const item = document.createElement("li");
        const canvas = document.createElement("canvas");
        canvas.width = canvas.height = 52;
        const c = canvas.getContext("2d");
        c.scale(2, 2);
        drawMark(c, shape, 13, 13, 7, colours[colour], colours.rim);
        item.append(canvas, count > 0 ? `${words}, ${count}` : `${words}, when zoomed`);
        return item;
      }),
    );
  }

  fault(message) {
    by("fault").textContent = message;
  }

  // --- every frame ------------------------------------------------------------------------------

  wake() {
    this.quiet = 0;
    if (this.running) return;
    this.running = true;
    requestAnimationFrame(() => this.frame());
  }

  async frame() {
    if (this.sound.running) this.take(await this.sound.look());
    this.draw();
    if (this.quiet > QUIET_FRAMES || document.hidden) this.running = false;
    else requestAnimationFrame(() => this.frame());
  }

  take(told) {
    this.meters = told;
    this.cursor = told.cursor;
    this.picture.trace.push(told.torque, told.struck);
    const rests = this.hand.holder === null && told.cursor < 1e-4 && told.envelope < 1e-4;
    this.quiet = rests ? this.quiet + 1 : 0;
    if (this.settings.felt === "motor" && this.settings.vibration) {
      this.motor.feel(told.envelope, performance.now());
    }
    if (this.hand.holder !== "keys") this.sayStruck(told.struck);
  }

  sayStruck(struck) {
    const named = struck.map(({ event }) => this.view.events[this.view.struck[event] ?? -1]);
    const last = named.filter(Boolean).at(-1);
    if (last) this.speech.say(eventText(last, this.info));
  }

  draw() {
    const touching = this.hand.holder !== null;
    if (!this.sound.running) this.quiet += 1;
    this.picture.draw({ cursor: this.cursor, hand: this.place, touching });
    this.slider.show(this.view, this.place, this.cursor, this.info);
  }
}

try {
  const data = await Data.open();
  const page = new Page(data, await Sound.open(data));
  await page.begin();
  window.overview = page;
} catch (error) {
  by("fault").textContent = `The page can't begin: ${error.message}`;
}
keepOffline();
