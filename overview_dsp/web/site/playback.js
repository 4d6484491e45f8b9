// Play, Share, and what an address asks for.

import { addressOf, momentOf, nameOf } from "./address.js";
import { by } from "./dom.js";
import { gestureOf, Player, wordsOf } from "./player.js";
import { partAbout, partBetween } from "./windows.js";
import { eventAt } from "./words.js";

/** @import { Gesture } from "../types" */
/** @import { Page } from "./page.js" */

const SHARED_MS = 3000;
const SILENT_MS = 2000; // a browser that can sound does so sooner

export class Playback {
  /** @param {Page} page */
  constructor(page) {
    this.page = page;
    /** @type {Gesture | null} */
    this.asked = null; // the gesture of the address, until it was played
    this.player = new Player(page.hand, (playing) => {
      by("run").textContent = playing ? "Pause" : "Play";
      page.wake();
    });
    by("start").addEventListener("click", () => this.toggle());
    by("share").addEventListener("click", () => this.share());
  }

  /** What Play plays: the address's gesture, or a sweep as long as is set. */
  get gesture() {
    return this.asked ?? gestureOf(`sweep:${this.page.settings.sweep}`);
  }

  toggle() {
    const { player, page } = this;
    page.start();
    by("start").hidden = true;
    if (player.playing) player.pause();
    else this.whenSounding(() => player.play(this.gesture));
  }

  /**
   * A browser takes a moment to sound; what is played before would be lost.
   * @param {() => void} act
   */
  async whenSounding(act) {
    const { sound, atHost } = this.page;
    if (!atHost) {
      await sound.load();
      let told = false;
      const waits = setTimeout(() => {
        told = true;
        this.page.fault("this browser has no sound output yet: it plays once there is one");
      }, SILENT_MS);
      await sound.context.resume();
      clearTimeout(waits);
      if (told) this.page.fault("");
    }
    this.page.wake();
    act();
  }

  /**
   * Go where an address says; its gesture waits for a touch.
   * @param {Record<string, string | null>} address
   */
  async follow({ at, play, window, preset }) {
    const { page } = this;
    const { windows, duration_s, server } = page.info;
    try {
      if (preset && server) await page.served.bench.use(preset);
      const ends = /** @type {[number, number]} */ (window?.split(":").map(Number));
      if (ends && ends[0] >= 0 && ends[1] > ends[0] && ends[1] <= duration_s) {
        const part = partBetween(windows, ends);
        await page.shown.go(part.number >= 0 || server
          ? part : partAbout(windows, part.zoom, (ends[0] + ends[1]) / 2));
      }
      const moment = momentOf(at, page.view.events);
      if (at && moment === null) throw new Error(`nothing here is called ${at}`);
      if (moment !== null) {
        const place = page.placeAt(moment);
        page.goTo(place, eventAt(page.view, place));
      }
      this.asked = gestureOf(play);
      if (play && this.asked === null) {
        throw new Error(`${play} can't be played; sweep:10 or tap:0.5 can`);
      }
    } catch (error) {
      page.fault(error.message);
    }
    by("start").hidden = this.asked === null;
  }

  /** This place, window and gesture as a link. */
  async share() {
    const { page } = this;
    const { view, info } = page;
    const { felt } = page;
    const address = addressOf({
      at: felt && nameOf(felt, view.events),
      window: view.zoom > 0 ? `${Math.round(view.start_s)}:${Math.round(view.end_s)}` : null,
      preset: info.server ? page.bench?.sounding?.name : null,
      play: wordsOf(this.gesture),
    });
    try {
      if (navigator.share) await navigator.share({ title: info.title, url: address });
      else await navigator.clipboard.writeText(address);
      by("share").textContent = navigator.share ? "Shared" : "Link copied";
    } catch (error) {
      if (error.name === "AbortError") return; // thought better of it
      page.fault(`this browser can't share; the link is ${address}`);
    }
    setTimeout(() => (by("share").textContent = "Share"), SHARED_MS);
  }
}
