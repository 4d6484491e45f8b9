// The film or recording of a timeline.

import { byId } from "./dom.js";
import { request } from "./session.js";

/** @import { Media } from "../types" */

const LEAD_S = 5;

export class MediaPlayer {
  /**
   * `media` has url, type and `offset_s`, the film's time at the timeline's start.
   * @param {Media} media
   */
  constructor(media) {
    this.dialog = byId("film");
    this.media = media;
    this.video = byId("film-video");
    this.dialog.addEventListener("close", () => this.video.pause());
  }

  /**
   * Play the film from a few seconds before a time (s of the timeline); throw an Error if it fails.
   * @param {number} moment
   * @param {string} title
   */
  async play(moment, title) {
    const { video } = this;
    byId("film-title").textContent = title;
    // loaded on demand; some players ignore a time in the URL
    const url = new URL(this.media.url, location.href).href;
    if (!video.src) video.src = url;
    const from = Math.max(0, moment + this.media.offset_s - LEAD_S);
    // the browser reads a growing file's new length only from another URL
    if (video.readyState > 0 && from > video.duration) video.src = `${url}?${Math.round(from)}`;
    if (video.readyState > 0) video.currentTime = from;
    else video.addEventListener("loadedmetadata", () => (video.currentTime = from), { once: true });
    this.dialog.showModal();
    try {
      await video.play();
    } catch (error) {
      if (error.name === "AbortError") return; // closed, or moved within the film
      this.dialog.close();
      video.removeAttribute("src"); // the next attempt loads the file again
      await request(url, { headers: { Range: "bytes=0-0" } });
      throw new Error(`this browser can't play the film (${this.media.type}): ${error.message}`);
    }
  }
}
