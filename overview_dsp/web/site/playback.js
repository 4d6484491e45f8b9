// Play, Share, and the actions of the URL.

import { linkTo, momentAt, eventName } from "./address.js";
import { byId } from "./dom.js";
import { gestureOf, Player, gestureText } from "./player.js";
import { partAround, partBetween } from "./windows.js";
import { eventAt } from "./descriptions.js";

/** @import { Gesture } from "../types" */
/** @import { Page } from "./page.js" */

const SHARED_MS = 3000;
const SILENT_MS = 2000; // longer than a working sound output needs to start

export class Playback {
  /** @param {Page} page */
  constructor(page) {
    this.page = page;
    /** @type {Gesture | null} */
    this.linkedGesture = null; // gesture of the URL, until it is played
    this.player = new Player(page.input, (playing, isEnd) => {
      byId("run").textContent = playing ? "Pause" : "Play";
      const stopped = isEnd ? "Ended" : "Paused";
      page.announcer.say(playing ? `Playing, ${this.player.gesture.seconds} seconds` : stopped);
      page.wake();
    });
    byId("start").addEventListener("click", () => this.toggle());
    byId("share").addEventListener("click", () => this.share());
  }

  /** The gesture that Play plays: that of the URL, or a sweep. */
  get gesture() {
    return this.linkedGesture ?? gestureOf(`sweep:${this.page.settings.sweep}`);
  }

  toggle() {
    const { player, page } = this;
    page.start();
    byId("start").hidden = true;
    if (player.playing) player.pause();
    else this.whenReady(() => player.play(this.gesture));
  }

  /**
   * Run an action once the sound runs, so that no sound is lost.
   * @param {() => void} act
   */
  async whenReady(act) {
    const { sound, atHost } = this.page;
    if (!atHost) {
      await sound.load();
      let isReported = false;
      const timer = setTimeout(() => {
        isReported = true;
        this.page.fault("this browser has no sound output yet; playback starts when it has");
      }, SILENT_MS);
      await sound.context.resume();
      clearTimeout(timer);
      if (isReported) this.page.fault("");
    }
    this.page.wake();
    act();
  }

  /**
   * Apply the fields of the URL; its gesture waits for a touch.
   * @param {Record<string, string | null>} address
   */
  async follow({ at, play, window, preset }) {
    const { page } = this;
    const { windows, duration_s, server } = page.info;
    try {
      if (preset && server) await page.served.editor.use(preset);
      const range = /** @type {[number, number]} */ (window?.split(":").map(Number));
      if (range && range[0] >= 0 && range[1] > range[0] && range[1] <= duration_s) {
        const part = partBetween(windows, range);
        await page.viewState.go(part.number >= 0 || server
          ? part : partAround(windows, part.zoom, (range[0] + range[1]) / 2));
      }
      const moment = momentAt(at, page.view.events);
      if (at && moment === null) throw new Error(`unknown position ${at}; use goal:5, 67:30 or seconds`);
      if (moment !== null) {
        const position = page.positionAt(moment);
        page.goTo(position, eventAt(page.view, position));
      }
      this.linkedGesture = gestureOf(play);
      if (play && this.linkedGesture === null) {
        throw new Error(`unknown gesture ${play}; use sweep:10 or tap:0.5`);
      }
    } catch (error) {
      page.fault(error.message);
    }
    byId("start").hidden = this.linkedGesture === null;
  }

  /** Share a link to this position, window and gesture. */
  async share() {
    const { page } = this;
    const { view, info } = page;
    const { currentEvent } = page;
    const address = linkTo({
      at: currentEvent && eventName(currentEvent, view.events),
      window: view.zoom > 0 ? `${Math.round(view.start_s)}:${Math.round(view.end_s)}` : null,
      preset: info.server ? page.editor?.playing?.name : null,
      play: gestureText(this.gesture),
    });
    try {
      if (navigator.share) await navigator.share({ title: info.title, url: address });
      else await navigator.clipboard.writeText(address);
      byId("share").textContent = navigator.share ? "Shared" : "Link copied";
    } catch (error) {
      if (error.name === "AbortError") return; // cancelled by the user
      page.fault(`this browser can't share; copy the link: ${address}`);
    }
    setTimeout(() => (byId("share").textContent = "Share"), SHARED_MS);
  }
}
