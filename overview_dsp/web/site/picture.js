// The picture: a static layer, the passed part of the curve over it, and moving parts.

import { byId, contextOf } from "./dom.js";
import { geometryOf, isOnDial, positionTurned } from "./geometry.js";
import { drawLayer, drawPassed, figuresOf, fontOf, markPoint } from "./layer.js";
import { Moving } from "./moving.js";
import { SvgContext } from "./svg.js";

/** @import { Colours, Geometry, Info, TimelineEvent, View } from "../types" */

export const COLOURS = ["paper", "ink", "soft", "line", "edge", "curve", "ahead", "fill", "groove", "groove2",
  "one", "two", "card", "red"];

const FINGER_PX = 20; // maximum distance from a pointer to a mark
const FIGURE_PX = 12; // space beside the axis figures

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

/** Return the size of the text, 1 for 16 px. */
export const textSize = () => parseFloat(getComputedStyle(document.documentElement).fontSize) / 16;

export class Picture {
  /**
   * @param {SVGSVGElement} layer
   * @param {Info} info
   * @param {View} view
   */
  constructor(layer, info, view) {
    this.layer = layer;
    this.info = info;
    this.view = view;
    this.moving = new Moving();
    this.measuring = contextOf(document.createElement("canvas"));
    this.still = this.circular = false;
    /** @type {Set<string>} */
    this.hidden = new Set(); // kinds without marks
    this.isTurningDial = false; // whether a finger turns the dial
    this.dialPosition = 0;
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
    const em = textSize();
    const { view, still, circular } = this;
    const isSeries = this.info.series !== null;
    const hasSides = view.events.some(({ side }) => side);
    /** @type {Geometry} */
    this.geometry = geometryOf({
      width, height, em, still, circular, figures: isSeries ? this.figuresWidth(height, em) : 0,
      lanes: isSeries || view.events.length === 0 ? 0 : 1 + Number(this.info.sides.length > 0 || hasSides),
    });
    this.moving.layOut(this.geometry);
    this.redraw();
  }

  /**
   * Return the width of the axis figures.
   * @param {number} height
   * @param {number} em
   */
  figuresWidth(height, em) {
    this.measuring.font = fontOf({ em });
    const widths = figuresOf(this.view, height * 0.8, em).map(({ text }) => this.measuring.measureText(text).width);
    return Math.max(0, ...widths) + FIGURE_PX - 26;
  }

  /** Draw the layer for another window, size or colours. */
  redraw() {
    /** @type {Colours} */
    this.colours = coloursOf(this.layer);
    if (this.geometry.width === 0) return;
    const { geometry: g, view, info, colours, hidden } = this;
    const layers = /** @type {const} */ ([[this.layer, drawLayer], [byId("passed-curve"), drawPassed]]);
    for (const [svg, draw] of layers) {
      const c = new SvgContext(svg);
      draw({ c, g, view, info, colours, hidden });
      c.show();
    }
  }

  /** @param {View} view */
  show(view) {
    this.view = view;
    this.resize();
  }

  /**
   * Draw one frame.
   * @param {{ cursor: number, input: number, touching: boolean, torque: number }} state
   */
  draw(state) {
    if (this.geometry.width > 0) this.moving.show(this.geometry, this.view, state);
  }

  /**
   * Return the position under a pointer: on the curve, or on the dial if the touch began there.
   * @param {{ clientX: number, clientY: number }} pointer
   * @param {boolean} begins whether a touch begins
   */
  positionUnder({ clientX, clientY }, begins = false) {
    const x = clientX - this.left;
    const y = clientY - this.top;
    const { dial } = this.geometry;
    if (begins) this.isTurningDial = isOnDial(this.geometry, x, y);
    if (!this.isTurningDial || dial === null) return this.geometry.position(x);
    const last = begins ? (x < dial.x ? 0 : 1) : this.dialPosition;
    this.dialPosition = positionTurned(dial, x, y, last);
    return this.dialPosition;
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
    const { geometry, view, info } = this;
    /** @type {TimelineEvent | null} */
    let nearest = null;
    let least = FINGER_PX;
    for (const event of view.events) {
      if (this.hidden.has(event.kind)) continue;
      const [x, y] = markPoint(geometry, view, info, event);
      const away = Math.hypot(x + this.left - clientX, y + this.top - clientY);
      if (away < least) [nearest, least] = [event, away];
    }
    return nearest;
  }
}
