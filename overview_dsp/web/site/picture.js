// The picture: a static layer, moving parts over it, and the trace on its own canvas.

import { geometryOf, isOnDisk, positionTurned } from "./geometry.js";
import { drawLayer, isDetail, markLevel } from "./layer.js";
import { Moving } from "./moving.js";
import { SvgContext } from "./svg.js";
import { Trace } from "./trace.js";

/** @import { Colours, Geometry, Info, TimelineEvent, View } from "../types" */

const COLOURS = ["paper", "ink", "soft", "line", "curve", "fill", "disk", "disk-mark", "accent",
  "cursor", "trace", "blue", "sky", "green", "yellow", "orange", "vermilion", "purple", "grey",
  "rim"];

const FINGER_PX = 20; // maximum distance from a pointer to a mark

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
   * @param {View} view
   */
  constructor(layer, trace, info, view) {
    this.layer = layer;
    this.info = info;
    this.view = view;
    this.moving = new Moving();
    this.trace = new Trace(trace, info.reference_torque);
    this.still = false;
    this.isTurningDisk = false; // whether a finger turns the disk
    this.diskPosition = 0;
    this.left = this.top = 0; // position on the screen
    this.resize();
  }

  /** Read the picture's position on the screen. It is stored, since reading it is slow. */
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
    this.moving.layOut(this.geometry);
    this.trace.layOut(this.geometry.trace, window.devicePixelRatio || 1);
    this.redraw();
  }

  /** Draw the layer for another window, size or colours. */
  redraw() {
    /** @type {Colours} */
    this.colours = coloursOf(this.layer);
    if (this.geometry.width === 0) return;
    const c = new SvgContext(this.layer);
    const { geometry: g, view, info, colours } = this;
    drawLayer({ c, g, view, info, colours });
    c.show();
  }

  /** @param {View} view */
  show(view) {
    this.view = view;
    this.redraw();
  }

  /**
   * Draw one frame.
   * @param {{ cursor: number, input: number, touching: boolean }} state
   */
  draw(state) {
    if (this.geometry.width === 0) return;
    this.moving.show(this.geometry, this.view, state, this.info);
    this.trace.draw(this.colours);
  }

  /**
   * Return the position under a pointer: on the curve, or on the disk if the touch began there.
   * @param {{ clientX: number, clientY: number }} pointer
   * @param {boolean} begins whether a touch begins
   */
  positionUnder({ clientX, clientY }, begins = false) {
    const x = clientX - this.left;
    const y = clientY - this.top;
    const { disk } = this.geometry;
    if (begins) this.isTurningDisk = isOnDisk(this.geometry, x, y);
    if (!this.isTurningDisk || disk === null) return this.geometry.position(x);
    const last = begins ? (x < disk.x ? 0 : 1) : this.diskPosition;
    this.diskPosition = positionTurned(disk, x, y, last);
    return this.diskPosition;
  }

  /** @param {number} clientX */
  positionOf(clientX) {
    return this.geometry.position(clientX - this.left);
  }

  /**
   * Return the event whose mark is at (clientX, clientY), or null.
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
      const up = geometry.y(markLevel(view, event));
      const away = Math.hypot(geometry.x(event.position) - x, up - y);
      if (away < least) [nearest, least] = [event, away];
    }
    return nearest;
  }
}
