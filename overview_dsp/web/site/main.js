// The page: data, sound, hand and picture put together.

import { Bench } from "./bench.js";
import { Data } from "./data.js";
import { Film } from "./film.js";
import { Hand } from "./hand.js";
import { HostSound } from "./host_sound.js";
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
import { levels, partAbout, partBeside, partBetween } from "./windows.js";
import { eventAt, eventPassed, eventText, momentText, placeText, secondsAt } from "./words.js";

const QUIET_FRAMES = 40; // after which an unheld disk at rest is looked at no more
const REST_MS = 250; // a slider that stands so long is drawn

const by = (id) => document.getElementById(id);

const isSame = (a, b) => a?.start_s === b?.start_s && a?.end_s === b?.end_s;

class Page {
  constructor(data, sound) {
    this.data = data;
    this.info = data.info;
    this.server = data.info.server;
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
    this.meters = null;
    this.cursor = 0;
    this.quiet = 0;
    this.running = false;
    this.begun = false;
    this.looking = false;
    this.going = false;
    this.view = null;
    this.film = this.server?.media ? new Film(by("film"), this.server.media) : null;
    this.bench = null;
  }

  async begin() {
    by("title").textContent = this.info.title;
    document.title = `${this.info.title}: overView`;
    document.documentElement.classList.toggle("host", this.atHost);
    this.tellAbout();
    this.apply();
    const { windows, duration_s } = this.info;
    const first = partBetween(windows, this.server?.window ?? [0, duration_s]);
    // what the sound begins with
    this.under = this.atHost ? first : partBetween(windows, [0, duration_s]);
    await this.go(first);
    this.listen();
    if (this.server) this.listenToServed();
    this.wake();
  }

  /** What only a server gives. */
  listenToServed() {
    by("play").hidden = this.film === null;
    by("play").addEventListener("click", () => this.play());
    by("tune").hidden = false;
    this.bench = new Bench((before, after, surface) => this.feel(before, after, surface));
    by("tune").addEventListener("click", () => {
      by("dialog").close();
      this.bench.toggle(true);
    });
    if (!this.atHost) return;
    const { sound } = this;
    sound.onlink = (text) => (by("link").textContent = text);
    sound.onlatency = (text) => (by("latency").textContent = text);
    sound.onshown = (window) => this.go(partBetween(this.info.windows, window));
    sound.onstatus = ({ cursor }) => {
      if (Math.abs(cursor - this.cursor) > 1e-4) this.wake();
    };
    sound.tell();
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

  /** Play the film from a little before where the disk is. */
  play() {
    if (this.film === null) return;
    const moment = secondsAt(this.view, this.cursor);
    const here = eventAt(this.view, this.cursor);
    const title = here ? eventText(here, this.info) : momentText(moment, this.info);
    this.film.play(here?.time_s ?? moment, title).catch((error) => this.fault(error.message));
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
    return this.go(partAbout(windows, level, secondsAt(this.view, place)));
  }

  beside(direction) {
    const next = partBeside(this.info.windows, this.view, direction);
    return next === null ? Promise.resolve(false) : this.go(next);
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

  /** Put a part under the hand; the moment a key holds stays under it. */
  async go(part) {
    if (this.going || isSame(part, this.view)) return false;
    this.going = true;
    try {
      const [view, put] = await Promise.all([
        this.data.view(part), isSame(part, this.under) ? null : this.sound.show(part),
      ]);
      const moment = this.view === null ? 0 : this.moment;
      put?.();
      this.under = part;
      this.view = view;
      this.picture.show(view);
      if (this.hand.holder === "keys") {
        this.hand.hold("keys", (moment - view.start_s) / (view.end_s - view.start_s));
      }
      this.tellWindow();
      this.fault("");
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
    const { zoom: level, start_s: start, end_s: end } = this.view;
    by("window").textContent = `${momentText(start, this.info)} to ${momentText(end, this.info)}`;
    by("in").disabled = level >= levels(windows);
    by("out").disabled = level === 0;
    by("earlier").hidden = by("later").hidden = level === 0;
    by("earlier").disabled = partBeside(windows, this.view, -1) === null;
    by("later").disabled = partBeside(windows, this.view, 1) === null;
  }

  /** Go over to another preset: its sound at once, its friction's picture when it rests. */
  async feel(before, after, surface) {
    await this.sound.feel(before, after, surface ? this.view : null);
    this.data.preset = after;
    if (!surface) return;
    clearTimeout(this.drawing);
    this.drawing = setTimeout(async () => {
      const part = this.view;
      const view = await this.data.view({
        number: part.number, zoom: part.zoom, start_s: part.start_s, end_s: part.end_s,
      });
      if (!isSame(part, this.view)) return;
      this.view = view;
      this.picture.show(view);
      this.wake();
    }, REST_MS);
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
    // ticks of time explain themselves
    const kinds = Object.values(this.info.kinds).filter((k) => k.count > 0 || k.shape !== "bar");
    by("kinds").replaceChildren(
      ...kinds.map(({ words, shape, colour, count }) => {
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

  frame() {
    if (this.view !== null) {
      this.draw();
      this.look();
    }
    if (this.quiet > QUIET_FRAMES || document.hidden) this.running = false;
    else requestAnimationFrame(() => this.frame());
  }

  /** Ask how the disk is, for the next frame. */
  async look() {
    if (!this.sound.running || this.looking) return;
    this.looking = true;
    this.take(await this.sound.look());
    this.looking = false;
  }

  take(told) {
    const before = this.cursor;
    this.meters = told;
    this.cursor = told.cursor;
    this.picture.trace.push(told.torque, told.struck);
    const rests = this.hand.holder === null && told.cursor < 1e-4 && told.envelope < 1e-4;
    this.quiet = rests ? this.quiet + 1 : 0;
    if (!this.atHost && this.settings.felt === "motor" && this.settings.vibration) {
      this.motor.feel(told.envelope, performance.now());
    }
    if (this.hand.holder === "keys") return;
    if (this.atHost) this.sayEvent(eventPassed(this.view, before, this.cursor));
    else this.sayStruck(told.struck);
  }

  sayStruck(struck) {
    const named = struck.map(({ event }) => this.view.events[this.view.struck[event] ?? -1]);
    this.sayEvent(named.filter(Boolean).at(-1));
  }

  sayEvent(event) {
    if (event) this.speech.say(eventText(event, this.info));
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
  const { server } = data.info;
  const page = new Page(data, server?.audio === "host" ? new HostSound() : await Sound.open(data));
  await page.begin();
  window.overview = page;
  if (!server) keepOffline();
} catch (error) {
  by("fault").textContent = `The page can't begin: ${error.message}`;
}
