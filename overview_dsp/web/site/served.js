// What only a server gives: the film, the bench, and the disk of a host.

import { secondsAt } from "./angle_map.js";
import { Bench } from "./bench.js";
import { by } from "./dom.js";
import { Film } from "./film.js";
import { HostSound } from "./host_sound.js";
import { PresetLink } from "./preset_link.js";
import { eventText, momentText } from "./words.js";

/** @import { OtherHand, Server, TimelineEvent } from "../types" */
/** @import { Page } from "./page.js" */

/**
 * The sound of a server that sounds itself, or null.
 * @param {Server} server
 */
export const hostSound = ({ audio }) => (audio === "host" ? new HostSound() : null);

/**
 * @param {Page} page
 * @param {Server} server
 */
export const serve = (page, server) => new Served(page, server);

export class Served {
  /**
   * `page`: what it is added to; `server`: of `info`.
   * @param {Page} page
   * @param {Server} server
   */
  constructor(page, server) {
    this.page = page;
    this.film = server.media ? new Film(by("film"), server.media) : null;
    this.bench = new Bench((before, after, surface) => page.feel(before, after, surface), page.hand);
    by("play").hidden = this.film === null;
    by("play").addEventListener("click", () => this.watch(page.felt));
    by("tune").hidden = false;
    by("tune").addEventListener("click", () => {
      by("dialog").close();
      this.bench.toggle(true);
    });
    this.presets = new PresetLink(page);
    if (page.atHost) this.listenToHost();
  }

  listenToHost() {
    const { page } = this;
    const sound = /** @type {HostSound} */ (page.sound);
    sound.onlink = (text) => (by("link").textContent = text);
    sound.onlatency = (text) => (by("latency").textContent = text);
    sound.onshown = (window) => page.shown.follow(window);
    sound.onstatus = ({ cursor }) => {
      if (Math.abs(cursor - page.cursor) > 1e-4) page.wake();
    };
    sound.onothers = (others) => this.showOthers(others);
    sound.call(page.settings.name);
    sound.tell();
  }

  /**
   * The other hands' fingers over the curve, each with its name.
   * @param {OtherHand[]} others
   */
  showOthers(others) {
    const { geometry } = this.page.picture;
    by("others").replaceChildren(...others.map(({ name, place, holding }) => {
      const finger = document.createElement("b");
      finger.textContent = name || "another";
      finger.className = holding ? "holding" : "";
      finger.style.transform = `translateX(${geometry.x(place).toFixed(1)}px)`;
      finger.style.top = `${geometry.top - 6}px`;
      return finger;
    }));
  }

  /**
   * Play the film from a little before an event, or where the disk is.
   * @param {TimelineEvent | null} event
   */
  watch(event) {
    const { film, page } = this;
    if (film === null) return;
    const { view, info, cursor } = page;
    const moment = event?.time_s ?? secondsAt(view, cursor);
    const title = event ? eventText(event, info) : momentText(moment, info);
    page.leave();
    film.play(moment, title).catch((error) => page.fault(error.message));
  }
}
