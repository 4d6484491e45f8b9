// Features that need a server: film, preset editor, and control of a host's disk.

import { PresetEditor } from "./preset_editor.js";
import { byId, made, on } from "./dom.js";
import { MediaPlayer } from "./media_player.js";
import { HostSound } from "./host_sound.js";
import { PresetLink } from "./preset_link.js";
import { eventText, momentText } from "./descriptions.js";

/** @import { OtherInput, ServedParts, Server, TimelineEvent } from "../types" */

/**
 * Return the sound of a host that plays (null if the page plays), and a function that adds the features.
 * @param {Server} server
 */
export function openServer({ audio, media, pages }) {
  const host = audio === "host" ? new HostSound() : null;
  return { host, serve: (/** @type {ServedParts} */ parts) => new Served(parts, media, pages, host) };
}

export class Served {
  /**
   * `host` is the page's sound if a host plays.
   * @param {ServedParts} parts
   * @param {Server["media"]} media
   * @param {Server["pages"]} pages
   * @param {HostSound | null} host
   */
  constructor(parts, media, pages, host) {
    this.parts = parts;
    document.head.append(made("link", { rel: "stylesheet", href: new URL("served.css", import.meta.url).href }));
    this.film = media && new MediaPlayer(media);
    this.editor = new PresetEditor(parts.changePreset, parts.input);
    byId("play").hidden = byId("watch").hidden = this.film === null;
    on("play", "click", () => this.watch(parts.readOut().event));
    byId("tune").hidden = false;
    on("tune", "click", () => {
      byId("dialog").close();
      this.editor.toggle(true);
    });
    byId("learn").hidden = !pages.includes("learn");
    on("learn", "click", () => location.assign("learn/"));
    this.presets = new PresetLink(parts, this.editor);
    if (host) this.listenToHost(host);
  }

  /** @param {HostSound} sound */
  listenToHost(sound) {
    const { actions, announcer, cursor, settings, viewState } = this.parts;
    sound.onlink = (text) => (byId("link").textContent = text);
    sound.onlatency = (text) => (byId("latency").textContent = text);
    sound.onwindow = (window) => viewState.follow(window);
    sound.onstatus = ({ cursor: position }) => {
      if (Math.abs(position - cursor()) > 1e-4) actions.wake();
    };
    sound.onothers = (others) => this.showOthers(others);
    on("mark", "click", () => {
      sound.link.mark();
      announcer.say("mark set");
    });
    sound.setName(settings.name);
    sound.report();
  }

  /**
   * Show the other inputs above the curve, each with its name.
   * @param {OtherInput[]} others
   */
  showOthers(others) {
    const { geometry } = this.parts.picture;
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
    const { film } = this;
    if (film === null) return;
    const { actions, info, readOut } = this.parts;
    const moment = event?.time_s ?? readOut().moment;
    const title = event ? eventText(event, info) : momentText(moment, info);
    actions.pause();
    film.play(moment, title).catch((error) => actions.fault(error.message));
  }
}
