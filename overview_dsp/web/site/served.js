// Features that need a server: film, preset editor, and control of a host's disk.

import { secondsAt } from "./angle_map.js";
import { PresetEditor } from "./preset_editor.js";
import { byId, made, on } from "./dom.js";
import { MediaPlayer } from "./media_player.js";
import { HostSound } from "./host_sound.js";
import { PresetLink } from "./preset_link.js";
import { eventText, momentText } from "./descriptions.js";

/** @import { OtherInput, Server, TimelineEvent } from "../types" */
/** @import { Page } from "./page.js" */

/**
 * Return the sound of a host that plays (null if the page plays), and a function that adds the features.
 * @param {Server} server
 */
export function openServer({ audio, media, pages }) {
  const host = audio === "host" ? new HostSound() : null;
  return { host, serve: (/** @type {Page} */ page) => new Served(page, media, pages, host) };
}

export class Served {
  /**
   * `page` gets the features; `host` is its sound if a host plays.
   * @param {Page} page
   * @param {Server["media"]} media
   * @param {Server["pages"]} pages
   * @param {HostSound | null} host
   */
  constructor(page, media, pages, host) {
    this.page = page;
    document.head.append(made("link", { rel: "stylesheet", href: new URL("served.css", import.meta.url).href }));
    this.film = media && new MediaPlayer(media);
    this.editor = new PresetEditor((before, after, surface) => page.changePreset(before, after, surface), page.input);
    byId("play").hidden = byId("watch").hidden = this.film === null;
    on("play", "click", () => this.watch(page.currentEvent));
    byId("tune").hidden = false;
    on("tune", "click", () => {
      byId("dialog").close();
      this.editor.toggle(true);
    });
    byId("learn").hidden = !pages.includes("learn");
    on("learn", "click", () => location.assign("learn/"));
    this.presets = new PresetLink(page, this.editor);
    if (host) this.listenToHost(host);
  }

  /** @param {HostSound} sound */
  listenToHost(sound) {
    const { page } = this;
    sound.onlink = (text) => (byId("link").textContent = text);
    sound.onlatency = (text) => (byId("latency").textContent = text);
    sound.onwindow = (window) => page.viewState.follow(window);
    sound.onstatus = ({ cursor }) => {
      if (Math.abs(cursor - page.cursor) > 1e-4) page.wake();
    };
    sound.onothers = (others) => this.showOthers(others);
    on("mark", "click", () => {
      sound.link.mark();
      page.announcer.say("mark set");
    });
    sound.setName(page.settings.name);
    sound.report();
  }

  /**
   * Show the other inputs above the curve, each with its name.
   * @param {OtherInput[]} others
   */
  showOthers(others) {
    const { geometry } = this.page.picture;
    byId("others").replaceChildren(...others.map(({ name, position, active }) => {
      const finger = made("b", { className: active ? "active" : "" }, name || "another");
      finger.style.transform = `translateX(${geometry.x(position).toFixed(1)}px)`;
      finger.style.top = `${geometry.groove - 6}px`;
      return finger;
    }));
  }

  /**
   * Play the film from a little before an event, or before the position that is read out.
   * @param {TimelineEvent | null} event
   */
  watch(event) {
    const { film, page } = this;
    if (film === null) return;
    const { view, info, reading } = page;
    const moment = event?.time_s ?? secondsAt(view, reading);
    const title = event ? eventText(event, info) : momentText(moment, info);
    page.pause();
    film.play(moment, title).catch((error) => page.fault(error.message));
  }
}
