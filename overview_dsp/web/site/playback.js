// Play, Share, and the actions of the URL.

import { eventName, linkTo, momentAt, readAddress } from "./address.js";
import { positionAt } from "./angle_map.js";
import { byId, on } from "./dom.js";
import { gestureOf, Player, gestureText, SWEEP } from "./player.js";
import { partBetween, partContaining } from "./windows.js";
import { momentText } from "./descriptions.js";
import { accessToken, openSession } from "./session.js";
import {
  afterEnd, cannotShare, COPIED, ENDED, noPreset, outsideWindow, PAUSE, PAUSED, PLAY, playing, SHARE, SHARED,
  THIS_COMPUTER, unknownGesture, unknownPosition, unknownWindow,
} from "./page_words.js";
import { fromTo } from "./words.js";

/** @import { AudioBackend, Gesture, Info, PageActions, Part, ReadOut, Settings } from "../types" */
/** @import { Announcer } from "./announcer.js" */
/** @import { CombinedInput } from "./combined_input.js" */
/** @import { PresetEditor } from "./preset_editor.js" */
/** @import { Strip } from "./strip.js" */
/** @import { ViewState } from "./view_state.js" */

const LOOPBACK = /^(localhost|127\..*|\[::1\])$/;
const SHARED_MS = 3000;
const PLAY_ICON = "M8 5v14l11-7z"; // as in index.html
const PAUSE_ICON = "M7 5h3v14H7zM14 5h3v14h-3z";

export class Playback {
  /**
   * `goTo(position)` moves the input; `readOut()` is what the page reads out, `editor()` the editor of a server.
   * @param {{ info: Info, input: CombinedInput, settings: Settings, sound: AudioBackend, viewState: ViewState,
   *   strip: Strip, announcer: Announcer, actions: PageActions, goTo: (position: number) => void,
   *   readOut: () => ReadOut, editor: () => PresetEditor | null }} parts
   */
  constructor(parts) {
    const { input, announcer, actions } = this.parts = parts;
    /** @type {Gesture | null} */
    this.linkedGesture = null; // gesture of the URL
    this.player = new Player(input, (sweep, isEnd) => {
      byId("run-text").textContent = sweep ? PAUSE : PLAY;
      byId("run").querySelector("path")?.setAttribute("d", sweep ? PAUSE_ICON : PLAY_ICON);
      const stopped = isEnd ? ENDED : PAUSED;
      announcer.say(sweep ? playing(sweep.seconds) : stopped);
      actions.wake();
    });
    on("share", "click", () => this.share());
  }

  /** The gesture that Play plays: that of the URL, or a sweep. */
  get gesture() {
    return this.linkedGesture ?? gestureOf(`sweep:${this.parts.settings.sweep}`) ?? SWEEP;
  }

  toggle() {
    const { player } = this;
    this.parts.actions.start();
    byId("run").classList.remove("offered");
    if (player.playing) player.pause();
    else this.whenReady(() => player.play(this.gesture));
  }

  /**
   * Run an action once the sound runs, so that no sound is lost, or once it is known that nothing will sound.
   * @param {() => void} act
   */
  async whenReady(act) {
    const { sound, actions } = this.parts;
    await sound.load();
    await sound.resume();
    actions.wake();
    act();
  }

  /**
   * Apply the fields of the URL; its gesture waits for Play. Each field works without the others.
   * @param {Record<string, string | null>} address
   */
  async follow({ at, play, window, preset }) {
    /** @type {string[]} */
    const faults = [];
    const steps = [
      preset && (() => this.usePreset(preset)), window && (() => this.showWindow(window)),
      at && (() => this.goTo(at, window)), () => this.offer(play),
    ];
    for (const step of steps) {
      try {
        if (step) await step();
      } catch (error) {
        faults.push(error.message);
      }
    }
    if (faults.length > 0) this.parts.actions.fault(faults.join("; "));
  }

  /** Follow another link that was opened in this page. */
  async followChange() {
    try {
      await openSession();
    } catch (error) {
      this.parts.actions.fault(error.message);
      return;
    }
    this.parts.actions.fault("");
    await this.follow(readAddress());
  }

  /** @param {string} preset */
  async usePreset(preset) {
    const { info } = this.parts;
    const editor = this.parts.editor();
    if (editor) await editor.use(preset);
    else if (preset !== info.preset) {
      throw new Error(noPreset(preset, info.preset));
    }
  }

  /** @param {string} text START:END in s */
  async showWindow(text) {
    const { windows, duration_s, server } = this.parts.info;
    const fields = text.split(":");
    const [start, end] = fields.map(Number);
    if (fields.length !== 2 || fields.includes("") || !(start >= 0 && end > start && end <= duration_s)) {
      throw new Error(unknownWindow(text, Math.floor(duration_s)));
    }
    const part = partBetween(windows, [start, end]);
    await this.show(part.number >= 0 || server ? part : partContaining(windows, [start, end]));
  }

  /**
   * Show a part, after a change that is under way.
   * @param {Part} part
   */
  async show(part) {
    const { viewState } = this.parts;
    await viewState.change;
    await viewState.go(part);
  }

  /**
   * Go to a position; without a `window` of the link, show the whole timeline if that has it.
   * @param {string} at
   * @param {string | null} window
   */
  async goTo(at, window) {
    const { info, strip, viewState } = this.parts;
    const { windows, duration_s } = info;
    const whole = partBetween(windows, [0, duration_s]);
    const moment = momentAt(at, strip.whole.events);
    if (moment === null) throw new Error(unknownPosition(at));
    const text = momentText(moment, info);
    if (moment > duration_s) {
      throw new Error(afterEnd(at, text, momentText(duration_s, info)));
    }
    const isOutside = () => moment < viewState.view.start_s || moment > viewState.view.end_s;
    if (isOutside() && !window) await this.show(whole);
    if (isOutside()) {
      const { start_s, end_s } = viewState.view;
      const ends = [start_s, end_s].map((one) => momentText(one, info));
      throw new Error(outsideWindow(at, text, fromTo(ends[0], ends[1])));
    }
    this.parts.goTo(positionAt(viewState.view, moment));
  }

  /**
   * Offer the gesture of the URL.
   * @param {string | null} play
   */
  offer(play) {
    this.linkedGesture = gestureOf(play);
    byId("run").classList.toggle("offered", this.linkedGesture !== null);
    byId("share-play").checked = this.linkedGesture !== null;
    byId("share-access").hidden = accessToken() === "";
    if (play && this.linkedGesture === null) {
      throw new Error(unknownGesture(play));
    }
  }

  /** Share a link to this position and window; with the gesture and the server's token if chosen. */
  async share() {
    const { info, strip, viewState: { view }, actions } = this.parts;
    const { event, moment } = this.parts.readOut();
    const button = byId("share");
    try {
      const address = linkTo({
        at: event ? eventName(event, strip.whole.events) : String(Math.round(moment)),
        window: view.zoom > 0 ? `${view.start_s}:${view.end_s}` : null,
        preset: this.parts.editor()?.playing?.name ?? null,
        play: byId("share-play").checked ? gestureText(this.gesture) : null,
        token: byId("share-token").checked ? accessToken() : null,
      });
      try {
        const hasSheet = Boolean(navigator.share);
        if (hasSheet) await navigator.share({ title: info.title, url: address });
        else await navigator.clipboard.writeText(address);
        button.textContent = hasSheet ? SHARED : COPIED;
        if (LOOPBACK.test(location.hostname)) button.textContent += THIS_COMPUTER;
      } catch (error) {
        if (error.name !== "AbortError") actions.fault(cannotShare(address));
      }
    } catch (error) {
      actions.fault(error.message);
    }
    setTimeout(() => (button.textContent = SHARE), SHARED_MS);
  }
}
