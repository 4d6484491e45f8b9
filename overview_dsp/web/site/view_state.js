// The visible part of the timeline, and its changes by zoom, shift and wheel.

import { positionAt, secondsAt } from "./angle_map.js";
import { byId } from "./dom.js";
import { titleParts } from "./scores.js";
import { lastLevel, partAround, neighbourPart, partBetween, partOf } from "./windows.js";
import { eventAt, momentText } from "./descriptions.js";
import { fromTo } from "./words.js";

/** @import { TimeRange, Part, AudioBackend, View } from "../types" */
/** @import { Data } from "./data.js" */
/** @import { CombinedInput } from "./combined_input.js" */
/** @import { Picture } from "./picture.js" */

const EVENT_PX = 3; // distance at which a position is at an event
const WHEEL_PX = 60; // per step
const WHEEL_REST_MS = 250; // pause that ends a turn of the wheel
const REST_MS = 250; // pause of a slider before the picture is drawn

/** @type {(a: TimeRange, b: TimeRange) => boolean} */
export const isSame = (a, b) => a.start_s === b.start_s && a.end_s === b.end_s;

export class ViewState {
  /**
   * `onshow()` is called after each change, `onfault(line)` with errors. The picture has the first view.
   * @param {{ data: Data, sound: AudioBackend, input: CombinedInput, picture: Picture, onshow: () => void, onfault: (line: string) => void }} parts
   */
  constructor({ data, sound, input, picture, onshow, onfault }) {
    this.data = data;
    this.windows = data.info.windows;
    this.sound = sound;
    this.input = input;
    this.picture = picture;
    this.onshow = onshow;
    this.onfault = onfault;
    this.view = picture.view;
    /** @type {TimeRange} */
    this.soundingPart = this.view; // part whose surface is active
    this.isChanging = false;
    this.change = Promise.resolve(true); // the latest change, settled once its view is shown
    /** Settled once the values of the view are loaded. */
    this.pointsLoaded = Promise.resolve();
    /** @type {Part | null} */
    this.nextPart = null; // next part of `goToLatest`
    this.wheelDistance = 0;
    this.lastWheelTime = 0;
  }

  /**
   * Show the first view; the sound starts with `soundingPart` and may change to the view.
   * @param {Part} soundingPart
   */
  async begin(soundingPart) {
    const { view } = this;
    this.setView(view, view.start_s);
    this.updateControls();
    if (!isSame(view, soundingPart)) (await this.sound.show(view))();
  }

  /** The position that is read out and drawn: the input's, or that of an event close to it. */
  get reading() {
    const { position } = this.input;
    return eventAt(this.view, position)?.position ?? position;
  }

  /** The time (s) that is read out. */
  get moment() {
    return secondsAt(this.view, this.reading);
  }

  /** Update the part of the view that depends on the picture's size. */
  resize() {
    const { left, right } = this.picture.geometry;
    this.view.tolerance = EVENT_PX / Math.max(right - left, 1);
  }

  /** @param {number} direction */
  zoom(direction, position = this.input.position) {
    const level = Math.min(Math.max(this.view.zoom + direction, 0), lastLevel(this.windows));
    if (level === this.view.zoom) return Promise.resolve(false);
    return this.go(partAround(this.windows, level, secondsAt(this.view, position)));
  }

  /** Show the whole timeline. */
  showWhole() {
    return this.go(partOf(this.windows, 0));
  }

  /** @param {number} direction */
  shift(direction) {
    return this.go(neighbourPart(this.windows, this.view, direction));
  }

  /** @param {WheelEvent} event */
  wheel({ deltaX, deltaY, shiftKey, clientX }) {
    const now = performance.now();
    const isHorizontal = Math.abs(deltaX) > Math.abs(deltaY) || shiftKey;
    this.wheelDistance = now - this.lastWheelTime > WHEEL_REST_MS ? 0 : this.wheelDistance;
    this.lastWheelTime = now;
    this.wheelDistance += isHorizontal ? deltaX || deltaY : deltaY;
    if (Math.abs(this.wheelDistance) < WHEEL_PX) return;
    const direction = Math.sign(this.wheelDistance);
    this.wheelDistance = 0;
    if (isHorizontal) this.shift(direction);
    else this.zoom(-direction, this.picture.positionOf(clientX));
  }

  /**
   * Show the window of a host, [start, end] in s.
   * @param {[number, number]} window
   */
  follow(window) {
    return this.go(partBetween(this.windows, window));
  }

  /** Whether a server can make any window. */
  get canShowAnyWindow() {
    return Boolean(this.data.info.server);
  }

  /**
   * Go to a part, if there is one; of several requests only the latest is kept.
   * @param {Part | null} part
   */
  async goToLatest(part) {
    this.nextPart = part;
    if (this.isQueueRunning) return;
    this.isQueueRunning = true;
    while (this.nextPart !== null) {
      const next = this.nextPart;
      this.nextPart = null;
      await this.go(next);
    }
    this.isQueueRunning = false;
  }

  /**
   * Show a part, if there is one, and activate its surface. Keys and a released input keep their time.
   * @param {Part | null} part
   */
  go(part) {
    if (part === null || this.isChanging || isSame(part, this.view)) return Promise.resolve(false);
    this.isChanging = true;
    this.change = this.changeTo(part);
    return this.change;
  }

  /** @param {Part} part */
  async changeTo(part) {
    try {
      const [view, apply] = await Promise.all([
        this.data.view(part), isSame(part, this.soundingPart) ? null : this.sound.show(part),
      ]);
      apply?.();
      this.soundingPart = part;
      this.setView(view);
      this.updateControls();
      this.onfault("");
      return true;
    } catch (error) {
      this.onfault(error.message);
      return false;
    } finally {
      this.isChanging = false;
    }
  }

  /**
   * @param {View} view
   * @param {number} moment time (s) of keys or of a released input
   */
  setView(view, moment = this.moment) {
    this.view = view;
    this.picture.show(view);
    this.resize();
    this.input.stayAt(positionAt(view, moment));
    this.onshow();
    this.pointsLoaded = this.fetchPoints(view);
  }

  /**
   * Load the data values after the picture.
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

  /** Draw the same part again after the preset has changed. */
  drawAgain() {
    clearTimeout(this.drawing);
    this.drawing = setTimeout(async () => {
      const { number, zoom, start_s, end_s } = this.view;
      const part = { number, zoom, start_s, end_s };
      const view = await this.data.view(part);
      if (isSame(part, this.view)) this.setView(view);
    }, REST_MS);
  }

  updateControls() {
    const { windows, view } = this;
    const { info } = this.data;
    const rest = view.zoom === 0 && info.start === null && titleParts(info)?.rest;
    byId("window").textContent = rest || fromTo(momentText(view.start_s, info), momentText(view.end_s, info));
    // not `disabled`: the button keeps the focus and reports that there is no more detail
    byId("in").setAttribute("aria-disabled", String(view.zoom >= lastLevel(windows)));
  }
}
