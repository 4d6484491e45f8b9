// The page: it connects data, sound, input and picture.

import { showAbout } from "./about.js";
import { readAddress } from "./address.js";
import { positionAt, secondsAt } from "./angle_map.js";
import { Announcer } from "./announcer.js";
import { byId, made } from "./dom.js";
import { fit } from "./fit.js";
import { Frames } from "./frames.js";
import { CombinedInput } from "./combined_input.js";
import { EventList } from "./event_list.js";
import { listenToBrowser, listenToButtons, listenToStage } from "./listening.js";
import { keepOffline } from "./offline.js";
import { chipsOf, fitLegend, listedKinds, showLegend, showTitle } from "./legend.js";
import { Pinch } from "./pinch.js";
import { Playback } from "./playback.js";
import { bindSettings, saveSettings, loadSettings } from "./settings.js";
import { ViewState } from "./view_state.js";
import { Slider } from "./slider.js";
import { Sound } from "./sound.js";
import { Speech } from "./speech.js";
import { Strip } from "./strip.js";
import { Strokes } from "./strokes.js";
import { Twist } from "./twist.js";
import { Motor } from "./vibration.js";
import { Navigation } from "./navigation.js";
import { isSameEvent } from "./scores.js";
import { partAround, partBetween } from "./windows.js";
import { eventAt, eventPassed, eventText } from "./descriptions.js";
import {
  DRAG_HERE, INTERRUPTED, kindShown, NEXT_EVENT, NEXT_VALUE, PREVIOUS_EVENT, PREVIOUS_VALUE, SILENT, TO_FEEL_IT,
  TWIST_OFF, TWIST_ON,
} from "./page_words.js";

/** @import { AudioBackend, DiskState, PageActions, Preset, ReadOut, ServedParts, TimelineEvent } from "../types" */
/** @import { AllValues } from "./all_values.js" */
/** @import { Data } from "./data.js" */
/** @import { Picture } from "./picture.js" */
/** @import { Served } from "./served.js" */

const SILENT_SHOWN_MS = 10_000;

export class Page {
  /**
   * @param {Data} data
   * @param {Picture} picture
   * @param {AudioBackend} sound
   */
  constructor(data, picture, sound) {
    this.data = data;
    this.info = data.info;
    this.sound = sound;
    this.atHost = this.info.server?.audio === "host";
    this.settings = loadSettings();
    this.input = new CombinedInput(
      new Strokes(sound.clock, (position, touching, sample) => sound.control(position, touching, sample)),
    );
    this.input.onchange = () => this.wake();
    this.picture = picture;
    this.slider = new Slider();
    this.speech = new Speech();
    this.announcer = new Announcer(byId("announcement"), this.slider);
    this.motor = new Motor();
    this.twist = new Twist(this.input, this.settings.start);
    this.twist.onsilent = (line) => {
      this.toggleTwist();
      this.fault(line);
    };
    this.viewState = new ViewState({
      data, sound, input: this.input, picture: this.picture,
      onshow: () => this.onViewChange(), onfault: (line) => this.fault(line),
    });
    this.strip = new Strip(data, this.viewState);
    this.pinch = new Pinch(this.viewState, picture, data);
    this.navigation = new Navigation(this.input, this.viewState, this.speech, this.announcer, this.info);
    this.frames = new Frames(sound, () => this.draw(), (meters) => this.update(meters));
    /** @type {PageActions} */
    this.actions = {
      fault: (line) => this.fault(line), wake: () => this.wake(), start: () => this.start(), pause: () => this.pause(),
    };
    this.playback = new Playback({
      info: this.info, input: this.input, settings: this.settings, sound, viewState: this.viewState, strip: this.strip,
      announcer: this.announcer, actions: this.actions, goTo: (position) => this.goTo(position),
      readOut: () => this.readOut, editor: () => this.editor,
    });
    /** @type {Served | null} */
    this.served = null;
    /** @type {DiskState | null} */
    this.meters = null;
    /** The last input that touched the disk. @type {string | null} */
    this.lastInput = null;
    this.cursor = 0;
    this.isOwn = this.wasFree = false; // whether this page moved a host's disk last, and it was released
    this.gain = 1; // of the setting
    /** @type {AllValues | null} */
    this.allValues = null;
    this.isStarted = false;
    this.hasSounded = this.interrupted = false;
    sound.onstate = (isRunning) => this.onSoundState(isRunning);
    sound.onsilence = () => {
      this.fault(SILENT);
      setTimeout(() => this.endSilence(), SILENT_SHOWN_MS);
      this.wake();
    };
    /** Called for each passed event. @type {(event: TimelineEvent) => void} */
    this.onenter = () => {};
    /** Called at each frame. */
    this.onmove = () => {};
  }

  /**
   * `serve(parts)` creates the features that need a server; null in a static folder.
   * @param {((parts: ServedParts) => Served) | null} serve
   */
  begin(serve) {
    document.documentElement.classList.toggle("host", this.atHost);
    const { windows, duration_s } = this.info;
    const soundingPart = this.atHost ? this.view : partBetween(windows, [0, duration_s]);
    this.viewState.begin(soundingPart).catch((error) => this.fault(error.message));
    this.apply();
    this.showAbout();
    const { actions, announcer, atHost, data, info, input, picture, settings, viewState } = this;
    this.served = serve && serve({
      actions, announcer, atHost, data, info, input, picture, settings, viewState, cursor: () => this.cursor,
      changePreset: (before, after, surface) => this.changePreset(before, after, surface), readOut: () => this.readOut,
    });
    this.listen();
    this.wake();
  }

  /** Add the listeners and the list of events. */
  listen() {
    const { actions: { start }, input, navigation, picture, pinch, viewState } = this;
    listenToStage({
      input, navigation, picture, pinch, viewState, start, open: (name) => this.open(name),
      ontap: (x, y) => this.onTap(x, y), reading: () => this.reading,
    });
    const isValues = () => this.settings.steps === "values" && this.info.series !== null;
    const step = (/** @type {number} */ direction) =>
      (isValues() ? navigation.toValue(direction) : navigation.toEvent(direction));
    const closed = (/** @type {() => void} */ act) => () => {
      byId("dialog").close();
      act();
    };
    listenToButtons({
      start,
      starting: {
        previous: () => step(-1), next: () => step(1), run: () => this.playback.toggle(),
        list: () => this.open("events"),
      },
      acts: {
        in: () => navigation.zoom(1), out: () => navigation.zoom(-1), whole: () => navigation.showWhole(),
        twist: closed(() => this.toggleTwist()), "all-values": closed(() => this.openValues()),
        settings: () => byId("dialog").showModal(), calibrate: () => this.calibrate(),
      },
      moves: { tap: () => navigation.tap(), release: () => navigation.release() },
    });
    bindSettings(byId("settings-form"), this.settings, () => this.apply());
    listenToBrowser({
      onhide: () => this.twist.on || this.pause(),
      onshow: () => this.resume(),
      onleave: () => this.pause(),
      onpicture: () => {
        picture.resize();
        viewState.resize();
        this.wake();
      },
      onsize: () => this.fit(),
      onscroll: () => picture.locate(),
      oncolours: () => {
        picture.redraw();
        this.strip.draw();
        this.wake();
      },
    });
    this.list = new EventList(this.info, navigation, {
      go: (event) => this.goToEvent(event), watch: this.film && ((event) => this.served?.watch(event)),
      hidden: picture.hidden, toggle: (kind) => this.toggleKind(kind),
    });
  }

  /** Load the sound, show that it loads, then follow the URL. */
  async load() {
    await this.sound.load();
    byId("hint-text").replaceChildren(DRAG_HERE, made("span", { className: "wide" }, TO_FEEL_IT));
    const { live } = this.info;
    if (live) {
      const { Live } = await import("./live.js");
      const { actions, announcer, atHost, data, info, input, motor, playback, settings, sound, speech } = this;
      this.live = new Live({
        actions, announcer, atHost, data, info, input, motor, playback, settings, sound, speech,
        viewState: this.viewState, showAbout: () => this.showAbout(),
      }, live);
    }
    await this.playback.follow(readAddress());
    window.addEventListener("hashchange", () => this.playback.followChange());
    this.wake();
  }

  get view() {
    return this.viewState.view;
  }

  get position() {
    return this.input.position;
  }

  get moment() {
    return secondsAt(this.view, this.reading);
  }

  /** What is read out: position, time and event. @returns {ReadOut} */
  get readOut() {
    return { position: this.reading, moment: this.moment, event: this.currentEvent };
  }

  get film() {
    return this.served?.film ?? null;
  }

  get editor() {
    return this.served?.editor ?? null;
  }

  /** The event at which the input is, or was released. */
  get currentEvent() {
    return eventAt(this.view, this.reading);
  }

  /** The position that is read out; of a host's disk that others moved last, the disk's. */
  get reading() {
    return this.atHost && !this.isOwn ? this.cursor : this.viewState.reading;
  }

  /**
   * Return the position (0 to 1) of a time (s) in the visible window.
   * @param {number} moment
   */
  positionAt(moment) {
    return positionAt(this.view, moment);
  }

  /** @param {number} position */
  goTo(position) {
    this.navigation.to(position);
    byId("slider").focus();
  }

  /**
   * Go to an event of the timeline; the window follows.
   * @param {TimelineEvent} event
   */
  async goToEvent(event) {
    const isInside = () => event.time_s >= this.view.start_s && event.time_s <= this.view.end_s;
    const part = isInside() ? null : partAround(this.info.windows, this.view.zoom, event.time_s);
    if (part) await this.playback.show(part);
    const own = this.view.events.find((one) => isSameEvent(one, event));
    if (own || isInside()) this.goTo(own?.position ?? this.positionAt(event.time_s));
  }

  /**
   * Open the list of events, the help or the film, or play and pause (run).
   * @param {string} name
   */
  open(name) {
    if (name === "run") this.playback.toggle();
    else if (name === "events") this.list?.open(this.view, this.strip.whole);
    else if (name === "help") byId("help").showModal();
    else this.served?.watch(this.currentEvent);
  }

  /** Open the table of all values and events. */
  async openValues() {
    const { AllValues: Table } = await import("./all_values.js");
    this.allValues ??= new Table(this.info);
    this.allValues.open(this.view);
  }

  /** @param {string} message */
  fault(message) {
    byId("fault").textContent = message;
    byId("fault").classList.toggle("link", message.includes("http")); // to be selected
  }

  // --- the input ---------------------------------------------------------------------------------

  /**
   * Play the film from an event whose mark was tapped.
   * @param {number} x
   * @param {number} y
   */
  onTap(x, y) {
    const event = this.film === null ? null : this.picture.markAt(x, y);
    if (event !== null) this.served?.watch(event);
  }

  /** Start the sound; browsers allow that only in a touch, a key press or a click. */
  start() {
    this.sound.start();
    if (!this.isStarted) {
      // here, since some browsers start the sound before a touch
      this.isStarted = true;
      navigator.serviceWorker?.ready.then(({ active }) => active?.postMessage("keep windows"));
    }
    if (this.sound.ready) document.documentElement.classList.add("touched");
    this.wake();
  }

  /** Continue after the page was hidden. */
  resume() {
    if (this.isStarted) this.sound.start();
    this.wake();
  }

  /**
   * Release the disk if another program, such as a call, takes the sound.
   * @param {boolean} isRunning
   */
  onSoundState(isRunning) {
    if (isRunning) {
      if (this.interrupted) this.fault("");
      this.endSilence();
    } else if (this.hasSounded) {
      this.pause();
      this.fault(INTERRUPTED);
    }
    this.interrupted = this.hasSounded && !isRunning;
    this.hasSounded ||= isRunning;
    this.wake();
  }

  /** Remove the message, which lies over the marks. */
  endSilence() {
    if (byId("fault").textContent === SILENT) this.fault("");
  }

  pause() {
    this.playback.player.pause();
    this.input.releaseAll();
    this.motor.stop();
    this.speech.stop();
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
    byId("twist").setAttribute("aria-pressed", String(this.twist.on));
    this.announcer.say(this.twist.on ? TWIST_ON : TWIST_OFF);
  }

  calibrate() {
    this.settings.start = this.twist.calibrate();
    saveSettings(this.settings);
  }

  // --- settings and presets ----------------------------------------------------------------------

  /**
   * Change to another preset; `surface`: whether the friction is drawn again.
   * @param {Preset} before
   * @param {Preset} after
   * @param {boolean} surface
   */
  async changePreset(before, after, surface) {
    await this.sound.changePreset(before, after, surface ? this.view : null);
    this.data.preset = after;
    if (surface) this.viewState.drawAgain();
  }

  apply() {
    const { output, clicks, vibration, volume, speech, contrast, still, circular, steps } = this.settings;
    this.gain = 10 ** (volume / 20);
    this.sound.route(output);
    this.sound.volume(clicks ? this.gain : 0, vibration ? this.gain : 0);
    if (!vibration || output !== "motor") this.motor.stop();
    this.sound.setName(this.settings.name.slice(0, 40));
    this.playback.player.loop = this.settings.loop;
    this.speech.on = speech;
    if (!speech) this.speech.stop();
    document.documentElement.classList.toggle("contrast", contrast);
    document.documentElement.classList.toggle("series", this.info.series !== null);
    const isValues = steps === "values" && this.info.series !== null;
    byId("previous").ariaLabel = isValues ? PREVIOUS_VALUE : PREVIOUS_EVENT;
    byId("next").ariaLabel = isValues ? NEXT_VALUE : NEXT_EVENT;
    this.picture.still = still;
    this.picture.circular = circular;
    this.picture.resize();
    this.strip.draw();
    this.wake();
  }

  /** Describe the data and list the kinds; a chip with the focus keeps it. */
  showAbout() {
    showAbout(byId("about"), this.info, this.view);
    showLegend(byId("marks"), this.info);
    showTitle(this.info);
    const focused = /** @type {HTMLElement | null} */ (document.activeElement)?.dataset.kind;
    const chips = chipsOf(this.info, this.picture.hidden, (kind) => this.toggleKind(kind));
    byId("legend").replaceChildren(...chips.map((chip) => made("li", {}, chip)));
    fitLegend();
    chips.find(({ dataset }) => dataset.kind === focused)?.focus();
  }

  /**
   * Show or hide the marks of a kind; its events are still felt.
   * @param {string} kind
   */
  toggleKind(kind) {
    const { hidden } = this.picture;
    if (!hidden.delete(kind)) hidden.add(kind);
    const shown = this.view.events.filter((event) => !hidden.has(event.kind)).length;
    const { name } = this.info.kinds[kind];
    this.announcer.say(kindShown(name, !hidden.has(kind), shown));
    this.picture.redraw();
    listedKinds(this.info).forEach(([id], i) => {
      byId("legend").querySelectorAll("button")[i].setAttribute("aria-pressed", String(!hidden.has(id)));
    });
  }

  /** Fit the texts to the window, and the picture to the rest. */
  fit(isResized = true) {
    this.list?.show(this.view, this.strip.whole);
    if (!fit(this.view, this.info, isResized)) return;
    fitLegend();
    this.picture.resize();
    this.viewState.resize();
    this.wake();
  }

  // --- every frame ------------------------------------------------------------------------------

  /** Update the strip after a change of the window. */
  onViewChange() {
    this.strip.show(this.view);
    this.fit(false);
    if (this.view.zoom === 0) fitLegend(); // while zoomed it is hidden
    this.wake();
  }

  wake() {
    this.frames.wake();
  }

  /**
   * Handle a new state of the disk.
   * @param {DiskState} state
   */
  update(state) {
    const before = this.cursor;
    this.meters = state;
    if (this.input.active !== null) [this.isOwn, this.wasFree] = [true, false];
    else if (!state.touching) this.wasFree = true;
    else if (this.wasFree) this.isOwn = false;
    // the disk may overrun an end slightly
    this.cursor = Math.min(Math.max(state.cursor, 0), 1);
    this.frames.setAtRest(this.input.active === null && state.cursor < 1e-4 && state.envelope < 1e-4);
    const { events, strike_events: strikeEvents } = this.view;
    const passed = this.atHost || this.sound.isSilent
      ? [eventPassed(this.view, before, this.cursor)]
      : state.newStrikes.map(({ event }) => events[strikeEvents[event] ?? -1]);
    this.announce(passed.filter((one) => !!one), state.peakTactor);
  }

  /**
   * Announce passed events by the motor and, unless keys move the disk, by speech.
   * @param {TimelineEvent[]} passed
   * @param {number} peak of the tactor
   */
  announce(passed, peak = 0) {
    const { output, vibration } = this.settings;
    if (!this.atHost && output === "motor" && vibration) {
      const patterns = passed.map(({ kind }) => this.info.kinds[kind].pattern);
      this.motor.play(patterns, peak / this.gain, performance.now());
    }
    passed.forEach(this.onenter);
    const last = passed.at(-1);
    if (last && this.input.active !== "keys") this.speech.speak(eventText(last, this.info));
  }

  draw() {
    const { active } = this.input;
    const touching = active !== null;
    this.lastInput = active ?? this.lastInput;
    const isLetGo = !touching && this.lastInput !== null && this.lastInput !== "play" && (!this.atHost || this.isOwn);
    byId("let-go").style.visibility = isLetGo ? "visible" : "";
    if (touching) this.list?.mark(this.currentEvent);
    const torque = (this.meters?.torque ?? 0) / this.info.reference_torque;
    this.picture.draw({ cursor: this.cursor, input: this.reading, touching, torque });
    this.slider.show(this.view, this.reading, this.info);
    this.onmove();
  }
}

/**
 * Start the page over an existing picture, as `window.overview`.
 * @param {Data} data
 * @param {Picture} picture with the first view
 */
export async function begin(data, picture) {
  const { server } = data.info;
  const served = server && (await import("./served.js")).openServer(server);
  const page = new Page(data, picture, served?.host ?? new Sound(data));
  page.begin(served && served.serve);
  /** @type {any} */ (window).overview = page;
  if (window.parent !== window && location.hash.includes("embed=")) {
    const { onenter, onmove } = (await import("./embedded.js")).embed({
      info: page.info, readOut: () => page.readOut, view: () => page.view, redraw: () => {
        page.picture.redraw();
        page.wake();
      },
    });
    [page.onenter, page.onmove] = [onenter, onmove];
  }
  await page.load();
  if (!server) keepOffline();
}
