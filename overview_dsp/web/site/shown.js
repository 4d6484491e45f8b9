// Which part of the timeline is under the hand, and how it comes there: zoom, beside, wheel.

import { placeAt, secondsAt } from "./angle_map.js";
import { by } from "./dom.js";
import { levels, partAbout, partBeside, partBetween } from "./windows.js";
import { momentText } from "./words.js";

/** @import { Ends, Part, SoundFace, View } from "../types" */
/** @import { Data } from "./data.js" */
/** @import { Hand } from "./hand.js" */
/** @import { Picture } from "./picture.js" */

const WHEEL_PX = 60; // a step
const WHEEL_REST_MS = 250; // after which a turn begins anew
const REST_MS = 250; // a slider that stands so long is drawn

/** @type {(a: Ends | null, b: Ends | null) => boolean} */
export const isSame = (a, b) => a?.start_s === b?.start_s && a?.end_s === b?.end_s;

export class Shown {
  /**
   * `onshow()` is called when another part is there, `onfault(line)` with what went wrong.
   * @param {{ data: Data, sound: SoundFace, hand: Hand, picture: Picture, onshow: () => void, onfault: (line: string) => void }} parts
   */
  constructor({ data, sound, hand, picture, onshow, onfault }) {
    this.data = data;
    this.windows = data.info.windows;
    this.sound = sound;
    this.hand = hand;
    this.picture = picture;
    this.onshow = onshow;
    this.onfault = onfault;
    /** @type {View | null} */
    this.view = null;
    /** @type {Ends | null} */
    this.under = null; // the part that sounds
    this.going = false;
    /** @type {Part | null} */
    this.wanted = null; // the part that `toward` goes to next
    this.turned = 0;
    this.wheeled = 0;
  }

  /**
   * The first view is there; the sound begins with the part `under`, or soon goes over to it.
   * @param {View} view
   * @param {Part} under
   */
  async begin(view, under) {
    this.under = view;
    this.take(view);
    this.tell();
    if (!isSame(view, under)) (await this.sound.show(view))();
  }

  /** The moment under the hand, s. */
  get moment() {
    return secondsAt(this.view, this.hand.place);
  }

  /** @param {number} direction */
  zoom(direction, place = this.hand.place) {
    const level = Math.min(Math.max(this.view.zoom + direction, 0), levels(this.windows));
    if (level === this.view.zoom) return Promise.resolve(false);
    return this.go(partAbout(this.windows, level, secondsAt(this.view, place)));
  }

  /** @param {number} direction */
  beside(direction) {
    const next = partBeside(this.windows, this.view, direction);
    return next === null ? Promise.resolve(false) : this.go(next);
  }

  /** @param {WheelEvent} event */
  wheel({ deltaX, deltaY, shiftKey, clientX }) {
    const now = performance.now();
    const along = Math.abs(deltaX) > Math.abs(deltaY) || shiftKey;
    this.turned = now - this.wheeled > WHEEL_REST_MS ? 0 : this.turned;
    this.wheeled = now;
    this.turned += along ? deltaX || deltaY : deltaY;
    if (Math.abs(this.turned) < WHEEL_PX) return;
    const direction = Math.sign(this.turned);
    this.turned = 0;
    if (along) this.beside(direction);
    else this.zoom(-direction, this.picture.placeOf(clientX));
  }

  /**
   * The window that a host shows, [start, end] in s.
   * @param {[number, number]} window
   */
  follow(window) {
    return this.go(partBetween(this.windows, window));
  }

  /** Whether any window can be made, or only those of the list. */
  get anywhere() {
    return Boolean(this.data.info.server);
  }

  /**
   * Go to a part; what is asked for meanwhile comes after it, the last alone.
   * @param {Part} part
   */
  async toward(part) {
    this.wanted = part;
    if (this.heading) return;
    this.heading = true;
    while (this.wanted !== null) {
      const next = this.wanted;
      this.wanted = null;
      await this.go(next);
    }
    this.heading = false;
  }

  /**
   * Put a part under the hand; the moment a key holds stays under it.
   * @param {Part} part
   */
  async go(part) {
    if (this.going || isSame(part, this.view)) return false;
    this.going = true;
    try {
      const [view, put] = await Promise.all([
        this.data.view(part), isSame(part, this.under) ? null : this.sound.show(part),
      ]);
      const moment = this.view === null ? 0 : this.moment;
      put?.();
      this.under = part;
      this.take(view);
      if (this.hand.holder === "keys") {
        this.hand.setDown("keys", placeAt(view, moment));
      }
      this.tell();
      this.onfault("");
      return true;
    } catch (error) {
      this.onfault(error.message);
      return false;
    } finally {
      this.going = false;
    }
  }

  /** @param {View} view */
  take(view) {
    this.view = view;
    this.picture.show(view);
    this.onshow();
    this.fetchPoints(view);
  }

  /**
   * The data's values come after the picture.
   * @param {View} view
   */
  async fetchPoints(view) {
    try {
      view.points = await this.data.points(view);
      this.onshow();
    } catch (error) {
      this.onfault(error.message);
    }
  }

  /** Draw the same part again as it is felt now, once that has rested. */
  drawAgain() {
    clearTimeout(this.drawing);
    this.drawing = setTimeout(async () => {
      const { number, zoom, start_s, end_s } = this.view;
      const part = { number, zoom, start_s, end_s };
      const view = await this.data.view(part);
      if (isSame(part, this.view)) this.take(view);
    }, REST_MS);
  }

  tell() {
    const { windows, view } = this;
    const { info } = this.data;
    const level = view.zoom;
    by("window").textContent =
      `${momentText(view.start_s, info)} to ${momentText(view.end_s, info)}`;
    by("in").disabled = level >= levels(windows);
    by("out").disabled = level === 0;
    by("earlier").hidden = by("later").hidden = level === 0;
    by("earlier").disabled = partBeside(windows, view, -1) === null;
    by("later").disabled = partBeside(windows, view, 1) === null;
  }
}
