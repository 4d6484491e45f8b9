// The film of a timeline: from a few seconds before a moment.

import { ask } from "./session.js";

/** @import { Media } from "../types" */

const LEAD_S = 5;

export class Film {
  /**
   * `media`: url, type, and `offset_s`, where in it the timeline begins.
   * @param {HTMLDialogElement} dialog
   * @param {Media} media
   */
  constructor(dialog, media) {
    this.dialog = dialog;
    this.media = media;
    this.video = dialog.querySelector("video");
    this.title = dialog.querySelector("h2");
    dialog.addEventListener("close", () => this.video.pause());
  }

  /**
   * Play what led to a moment (s of the timeline); an Error in a person's words if it can't.
   * @param {number} moment
   * @param {string} title
   */
  async play(moment, title) {
    const { video } = this;
    this.title.textContent = title;
    // fetched only when it is asked for; a fragment would be forgotten by some players
    const url = new URL(this.media.url, location.href).href;
    if (!video.src) video.src = url;
    const from = Math.max(0, moment + this.media.offset_s - LEAD_S);
    // a file that grows is longer by now, which a browser only believes of another address
    if (video.readyState > 0 && from > video.duration) video.src = `${url}?${Math.round(from)}`;
    if (video.readyState > 0) video.currentTime = from;
    else video.addEventListener("loadedmetadata", () => (video.currentTime = from), { once: true });
    this.dialog.showModal();
    try {
      await video.play();
    } catch (error) {
      if (error.name === "AbortError") return; // closed, or gone elsewhere in it
      this.dialog.close();
      video.removeAttribute("src"); // it is looked for again
      await ask(url, { headers: { Range: "bytes=0-0" } });
      throw new Error(`this browser can't play the film (${this.media.type}): ${error.message}`);
    }
  }
}
