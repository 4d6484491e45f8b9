// The picture: a layer that stands still, what moves over it, and the trace on a canvas of its own.

import { geometryOf, isOnDisk, placeTurned } from "./geometry.js";
import { drawLayer, isDetail, levelAt } from "./layer.js";
import { Moving } from "./moving.js";
import { SvgContext } from "./svg.js";
import { Trace } from "./trace.js";

/** @import { Colours, Geometry, Info, TimelineEvent, View } from "../types" */

const COLOURS = ["paper", "ink", "soft", "line", "curve", "fill", "disk", "disk-mark", "hand",
  "cursor", "trace", "blue", "sky", "green", "yellow", "orange", "vermilion", "purple", "grey",
  "rim"];

const FINGER_PX = 20; // a mark is hit as near as that

/**
 * @param {Element} element
 * @returns {Colours}
 */
export function coloursOf(element) {
  const style = getComputedStyle(element);
  return Object.fromEntries(
    COLOURS.map((name) => [name, style.getPropertyValue(`--${name}`).trim()]),
  );
}

export class Picture {
  /**
   * `layer` is an SVG, `trace` a canvas.
   * @param {SVGSVGElement} layer
   * @param {HTMLCanvasElement} trace
   * @param {Info} info
   */
  constructor(layer, trace, info) {
    this.layer = layer;
    this.info = info;
    this.moving = new Moving();
    this.trace = new Trace(trace, info.full_torque);
    this.still = false;
    this.turning = false; // whether a finger turns the disk
    this.turned = 0;
    /** @type {View | null} */
    this.view = null;
    this.resize();
  }

  /** Where it is on the screen: asked for now, since at every move it would cost a layout. */
  locate() {
    const { left, top, width, height } = this.layer.getBoundingClientRect();
    this.left = left;
    this.top = top;
    return { width, height };
  }

  resize() {
    const { width, height } = this.locate();
    const em = parseFloat(getComputedStyle(document.documentElement).fontSize) / 16;
    const short = Math.min(window.innerWidth, window.innerHeight);
    /** @type {Geometry} */
    this.geometry = geometryOf({ width, height, short, em, still: this.still });
    this.moving.place(this.geometry);
    this.trace.place(this.geometry.trace, window.devicePixelRatio || 1);
    this.redraw();
  }

  /** The layer again: another window, size or colours. */
  redraw() {
    this.colours = coloursOf(this.layer);
    if (!this.view || this.geometry.width === 0) return;
    const c = new SvgContext(this.layer);
    drawLayer(c, this.geometry, this.view, this.info, this.colours);
    c.show();
  }

  /** @param {View} view */
  show(view) {
    this.view = view;
    this.redraw();
  }

  /**
   * A frame.
   * @param {{ cursor: number, hand: number, touching: boolean }} state
   */
  draw(state) {
    if (!this.view || this.geometry.width === 0) return;
    this.moving.show(this.geometry, this.view, state, this.info);
    this.trace.draw(this.colours);
  }

  /**
   * The place that a pointer means: over the curve, or turning the disk if it came down there.
   * @param {{ clientX: number, clientY: number }} pointer
   */
  placeUnder({ clientX, clientY }, first = false) {
    const x = clientX - this.left;
    const y = clientY - this.top;
    if (first) this.turning = isOnDisk(this.geometry, x, y);
    if (!this.turning) return this.geometry.place(x);
    const last = first ? (x < this.geometry.disk.x ? 0 : 1) : this.turned;
    this.turned = placeTurned(this.geometry.disk, x, y, last);
    return this.turned;
  }

  /** @param {number} clientX */
  placeOf(clientX) {
    return this.geometry.place(clientX - this.left);
  }

  /**
   * The event whose mark is there (clientX, clientY), or null.
   * @param {number} clientX
   * @param {number} clientY
   * @returns {TimelineEvent | null}
   */
  markAt(clientX, clientY) {
    const { geometry, view } = this;
    const x = clientX - this.left;
    const y = clientY - this.top;
    let nearest = null;
    let least = FINGER_PX;
    for (const event of view.events) {
      if (isDetail(this.info, event.kind)) continue;
      const up = geometry.y(levelAt(view, event.place));
      const away = Math.hypot(geometry.x(event.place) - x, up - y);
      if (away < least) [nearest, least] = [event, away];
    }
    return nearest;
  }
}
