// The picture: a layer that stands still, what moves over it, and the trace on a canvas of its own.

import { geometryOf } from "./geometry.js";
import { drawLayer, isDetail, levelAt } from "./layer.js";
import { Moving } from "./moving.js";
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
  /** `layer` and `trace` are canvases. */
  constructor(layer, trace, info) {
    this.layer = layer;
    this.info = info;
    this.moving = new Moving();
    this.trace = new Trace(trace, info.full_torque);
    this.still = false;
    this.view = null;
    this.resize();
  }

  resize() {
    const { layer } = this;
    const { left, top, width, height } = layer.getBoundingClientRect();
    this.left = left; // asked for now, since at every move it would cost a layout
    this.top = top;
    this.scale = Math.min(window.devicePixelRatio || 1, 3);
    layer.width = Math.round(width * this.scale);
    layer.height = Math.round(height * this.scale);
    const em = parseFloat(getComputedStyle(document.documentElement).fontSize) / 16;
    const short = Math.min(window.innerWidth, window.innerHeight);
    this.geometry = geometryOf({ width, height, short, em, still: this.still });
    this.moving.place(this.geometry);
    this.trace.place(this.geometry.trace, this.scale);
    this.redraw();
  }

  /** The layer again: another window, size or colours. */
  redraw() {
    this.colours = coloursOf(this.layer);
    if (!this.view || this.geometry.width === 0) return;
    const c = this.layer.getContext("2d");
    c.setTransform(this.scale, 0, 0, this.scale, 0, 0);
    drawLayer(c, this.geometry, this.view, this.info, this.colours);
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
