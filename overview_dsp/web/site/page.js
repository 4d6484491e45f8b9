// The page: data, sound, hand and picture put together, and what a person does with them.

import { tellAbout } from "./about.js";
import { readAddress } from "./address.js";
import { placeAt } from "./angle_map.js";
import { by } from "./dom.js";
import { Frames } from "./frames.js";
import { Hand } from "./hand.js";
import { listen } from "./listening.js";
import { keepOffline } from "./offline.js";
import { Pinch } from "./pinch.js";
import { Playback } from "./playback.js";
import { keepSettings, loadSettings } from "./settings.js";
import { Shown } from "./shown.js";
import { Slider } from "./slider.js";
import { Sound } from "./sound.js";
import { Speech } from "./speech.js";
import { Strip } from "./strip.js";
import { Strokes } from "./strokes.js";
import { Twist } from "./twist.js";
import { Motor } from "./vibration.js";
import { Walk } from "./walk.js";
import { partBetween } from "./windows.js";
import { eventAt, eventPassed, eventText } from "./words.js";

/** @import { Info, Preset, Server, Settings, SoundFace, TimelineEvent, Told, View } from "../types" */
/** @import { Data } from "./data.js" */
/** @import { Picture } from "./picture.js" */
/** @import { Served } from "./served.js" */

export class Page {
  /**
   * `served` makes, of a page and `info.server`, what only a server gives; null in a folder.
   * @param {Data} data
   * @param {Picture} picture
   * @param {SoundFace} sound
   * @param {((page: Page, server: Server) => Served) | null} served
   */
  constructor(data, picture, sound, served) {
    this.data = data;
    this.info = data.info;
    this.sound = sound;
    this.atHost = this.info.server?.audio === "host";
    this.makeServed = served;
    this.settings = loadSettings();
    this.hand = new Hand(
      new Strokes(sound.clock, (place, touching, sample) => sound.control(place, touching, sample)),
    );
    this.picture = picture;
    const told = ["slider", "clock", "value", "event", "summary"];
    this.slider = new Slider(Object.fromEntries(told.map((id) => [id, by(id)])));
    this.speech = new Speech();
    this.motor = new Motor();
    this.twist = new Twist(this.hand, this.settings.start);
    this.twist.onsilent = (line) => {
      this.toggleTwist();
      this.fault(line);
    };
    this.shown = new Shown({
      data, sound, hand: this.hand, picture: this.picture,
      onshow: () => this.seen(), onfault: (line) => this.fault(line),
    });
    this.strip = new Strip(data, this.shown);
    this.pinch = new Pinch(this.shown, picture, () => this.strip.whole);
    this.walk = new Walk(this.hand, this.shown, this.speech, this.info);
    this.frames = new Frames(sound, () => this.draw(), (meters) => this.take(meters));
    this.playback = new Playback(this);
    /** @type {Served | null} */
    this.served = null;
    /** @type {Told | null} */
    this.meters = null;
    this.cursor = 0;
    /** @type {TimelineEvent | null} */
    this.last = null; // the event that was felt last under a hand
    this.begun = false;
    this.sounded = this.interrupted = false;
    sound.onstate = (sounds) => this.heard(sounds);
  }

  /** @param {View} view */
  begin(view) {
    document.documentElement.classList.toggle("host", this.atHost);
    const { windows, duration_s, server } = this.info;
    const under = this.atHost ? view : partBetween(windows, [0, duration_s]);
    this.shown.begin(view, under).catch((error) => this.fault(error.message));
    this.apply();
    if (server) this.served = this.makeServed(this, server);
    this.list = listen(this);
    this.wake();
  }

  /** Fetch the sound, saying so; then what the address asks for. */
  async load() {
    const hint = by("hint").textContent;
    if (!this.atHost) {
      by("hint").textContent = "The sound is loading…";
      await this.sound.load();
    }
    by("hint").textContent = hint;
    if (this.info.live) {
      const { Live } = await import("./live.js");
      this.live = new Live(this, this.info.live);
    }
    await this.playback.follow(readAddress());
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

  /** The event a person means: under the disk while it is held, else the one felt last. */
  get felt() {
    return this.hand.holder === null ? this.last : eventAt(this.view, this.meant);
  }

  /** Where a person is: the disk under a finger comes after it, keys say where they go. */
  get meant() {
    return this.hand.holder === "keys" ? this.place : this.cursor;
  }

  /**
   * The place of a moment (s) in the window that is shown, 0 to 1.
   * @param {number} moment
   */
  placeAt(moment) {
    return placeAt(this.view, moment);
  }

  /**
   * @param {number} place
   * @param {TimelineEvent | null} event what is there
   */
  goTo(place, event) {
    by("slider").focus();
    this.last = event;
    this.walk.to(place);
  }

  /**
   * Open the list of events, the help or the film.
   * @param {string} name
   */
  open(name) {
    if (name === "run") this.playback.toggle();
    else if (name === "events") this.list.open(this.view);
    else if (name === "help") by("help").showModal();
    else this.served?.watch(this.felt);
  }

  /** @param {string} message */
  fault(message) {
    by("fault").textContent = message;
  }

  // --- the hand ---------------------------------------------------------------------------------

  /**
   * A short touch on an event's mark watches it, where there is a film; whether it did.
   * @param {number} x
   * @param {number} y
   */
  tapped(x, y) {
    const event = this.film === null ? null : this.picture.markAt(x, y);
    if (event === null) return;
    this.last = event;
    this.served.watch(event);
  }

  /** In a touch, a key or a click. */
  start() {
    this.sound.start();
    if (!this.begun) {
      // not of the sound, which some browsers let run before a touch
      this.begun = true;
      navigator.serviceWorker?.ready.then(({ active }) => active?.postMessage("keep windows"));
    }
    if (this.sound.running || this.sound.node) by("hint").classList.add("gone");
    this.wake();
  }

  /** What stopped while nobody looked goes on. */
  comeBack() {
    if (this.begun) this.sound.start();
    this.wake();
  }

  /**
   * A call came, or went: whoever held lets go, and another touch goes on.
   * @param {boolean} sounds
   */
  heard(sounds) {
    if (sounds) {
      if (this.interrupted) this.fault("");
    } else if (this.sounded) {
      this.leave();
      this.fault("the sound was interrupted: touch to go on");
    }
    this.interrupted = this.sounded && !sounds;
    this.sounded ||= sounds;
    this.wake();
  }

  leave() {
    this.playback.player.pause();
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

  /**
   * Go over to another preset: its sound at once, its friction's picture when it rests.
   * @param {Preset} before
   * @param {Preset} after
   * @param {boolean} surface
   */
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
    if (this.atHost) this.sound.call(this.settings.name.slice(0, 40));
    this.playback.player.loop = this.settings.loop;
    this.speech.on = speech;
    if (!speech) this.speech.still();
    document.documentElement.classList.toggle("contrast", contrast);
    this.picture.still = still;
    this.picture.resize();
    this.strip.draw();
    this.tellAbout();
    this.wake();
  }

  tellAbout() {
    tellAbout(by("about"), [...document.querySelectorAll(".kinds")], this.info, this.view);
  }

  // --- every frame ------------------------------------------------------------------------------

  /** Another window is shown. */
  seen() {
    this.strip.show(this.view);
    this.wake();
  }

  wake() {
    if (this.view !== null) this.frames.wake();
  }

  /**
   * What the sound told of the disk.
   * @param {Told} told
   */
  take(told) {
    const before = this.cursor;
    this.meters = told;
    // an end may be overrun by a hair: there is no time before the start
    this.cursor = Math.min(Math.max(told.cursor, 0), 1);
    this.picture.trace.push(told.torque, told.struck);
    this.frames.rests(this.hand.holder === null && told.cursor < 1e-4 && told.envelope < 1e-4);
    if (this.hand.holder !== null) this.last = eventAt(this.view, this.meant) ?? this.last;
    const { events, struck } = this.view;
    const passed = this.atHost
      ? [eventPassed(this.view, before, this.cursor)]
      : told.struck.map(({ event }) => events[struck[event] ?? -1]);
    this.tell(passed.filter(Boolean), told.peakTactor);
  }

  /**
   * What was struck or passed goes to the motor and, unless the keys hold, to speech.
   * @param {TimelineEvent[]} passed
   * @param {number} peak
   */
  tell(passed, peak) {
    const { felt, vibration } = this.settings;
    if (!this.atHost && felt === "motor" && vibration) {
      const codes = passed.map(({ kind }) => this.info.kinds[kind].pulse);
      this.motor.feel(codes, peak / this.gain, performance.now());
    }
    const last = passed.at(-1);
    if (last && ![null, "keys"].includes(this.hand.holder)) this.last = last;
    if (last && this.hand.holder !== "keys") this.speech.say(eventText(last, this.info));
  }

  draw() {
    const touching = this.hand.holder !== null;
    this.picture.draw({ cursor: this.cursor, hand: this.place, touching });
    this.slider.show(this.view, this.place, this.cursor, this.info);
  }
}

/**
 * The page over a picture that is there already, as `window.overview`.
 * @param {Data} data
 * @param {Picture} picture
 * @param {View} view
 */
export async function begin(data, picture, view) {
  const { server } = data.info;
  const served = server ? await import("./served.js") : null;
  const sound = served?.hostSound(server) ?? new Sound(data);
  const page = new Page(data, picture, sound, served?.serve);
  page.begin(view);
  /** @type {any} */ (window).overview = page;
  await page.load();
  if (!server) keepOffline();
}
