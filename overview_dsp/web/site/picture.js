// The picture: a layer that stands still, what moves over it, and the trace on a canvas of its own.

import { geometryOf, isOnDisk, placeTurned } from "./geometry.js";
import { drawLayer, isDetail, levelAt } from "./layer.js";
import { Moving } from "./moving.js";
import { SvgContext } from "./svg.js";
import { Trace } from "./trace.js";

const COLOURS = ["paper", "ink", "soft", "line", "curve", "fill", "disk", "disk-mark", "hand",
  "cursor", "trace", "blue", "sky", "green", "yellow", "orange", "vermilion", "purple", "grey",
  "rim"];

const FINGER_PX = 20; // a mark is hit as near as that

export function coloursOf(element) {
  const style = getComputedStyle(element);
  return Object.fromEntries(
    COLOURS.map((name) => [name, style.getPropertyValue(`--${name}`).trim()]),
  );
}

export class Picture {
  /** `layer` is an SVG, `trace` a canvas. */
  constructor(layer, trace, info) {
    this.layer = layer;
    this.info = info;
    this.moving = new Moving();
    this.trace = new Trace(trace, info.full_torque);
    this.still = false;
    this.turning = false; // whether a finger turns the disk
    this.turned = 0;
    this.view = null;
    this.resize();
  }

  resize() {
    const { layer } = this;
    const { left, top, width, height } = layer.getBoundingClientRect();
    this.left = left; // asked for now, since at every move it would cost a layout
    this.top = top;
    const em = parseFloat(getComputedStyle(document.documentElement).fontSize) / 16;
    const short = Math.min(window.innerWidth, window.innerHeight);
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

  show(view) {
    this.view = view;
    this.redraw();
  }

  /** A frame. */
  draw(state) {
    if (!this.view || this.geometry.width === 0) return;
    this.moving.show(this.geometry, this.view, state, this.info);
    this.trace.draw(this.colours);
  }

  /** The place that a pointer means: over the curve, or turning the disk if it came down there. */
  placeUnder({ clientX, clientY }, first = false) {
    const x = clientX - this.left;
    const y = clientY - this.top;
    if (first) this.turning = isOnDisk(this.geometry, x, y);
    if (!this.turning) return this.geometry.place(x);
    const last = first ? (x < this.geometry.disk.x ? 0 : 1) : this.turned;
    this.turned = placeTurned(this.geometry.disk, x, y, last);
    return this.turned;
  }

  placeOf(clientX) {
    return this.geometry.place(clientX - this.left);
  }

  /** The event whose mark is there (clientX, clientY), or null. */
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
