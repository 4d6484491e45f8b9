// Two canvases: a layer that stands still, and over it what moves.

import { geometryOf } from "./geometry.js";
import { drawLayer } from "./layer.js";
import { drawMoving } from "./moving.js";
import { Trace } from "./trace.js";

const COLOURS = ["paper", "ink", "soft", "line", "curve", "fill", "disk", "disk-mark", "hand",
  "cursor", "trace", "blue", "sky", "green", "yellow", "orange", "vermilion", "purple", "grey",
  "rim"];

export function coloursOf(element) {
  const style = getComputedStyle(element);
  return Object.fromEntries(
    COLOURS.map((name) => [name, style.getPropertyValue(`--${name}`).trim()]),
  );
}

export class Picture {
  constructor(layer, canvas, info) {
    this.canvas = canvas;
    this.info = info;
    this.c = canvas.getContext("2d");
    this.layer = layer;
    this.trace = new Trace(info.full_torque);
    this.still = false;
    this.view = null;
    this.resize();
  }

  resize() {
    const { canvas } = this;
    const { left, width, height } = canvas.getBoundingClientRect();
    this.left = left; // asked for now, since at every move it would cost a layout
    const scale = Math.min(window.devicePixelRatio || 1, 3);
    for (const one of [canvas, this.layer]) {
      one.width = Math.round(width * scale);
      one.height = Math.round(height * scale);
    }
    this.scale = scale;
    this.geometry = geometryOf(width, height, this.still);
    this.redraw();
  }

  /** The layer again: another window, size or colours. */
  redraw() {
    this.colours = coloursOf(this.canvas);
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
    const { c, geometry, canvas } = this;
    c.setTransform(1, 0, 0, 1, 0, 0);
    c.clearRect(0, 0, canvas.width, canvas.height);
    if (!this.view || canvas.width === 0) return;
    c.setTransform(this.scale, 0, 0, this.scale, 0, 0);
    drawMoving(c, geometry, this.view, state, this.info, this.colours);
    if (geometry.trace) {
      this.trace.draw(c, geometry.trace, this.colours);
    }
  }

  placeOf(clientX) {
    return this.geometry.place(clientX - this.left);
  }
}
