// An SVG with the canvas methods that the static picture needs. A canvas of that size would be passed
// to the compositor with every frame.

import { contextOf } from "./dom.js";

/** @param {number} number */
const round = (number) => Math.round(number * 100) / 100;
/** @type {Record<string, string>} */
const ANCHOR = { left: "start", center: "middle", right: "end" };
/** @type {Record<string, number>} */
const BASELINE = { top: 0.8, alphabetic: 0, bottom: -0.22 }; // offset below the point, in units of the size
const measuring = document.createElement("canvas");

export class SvgContext {
  /** @param {SVGSVGElement} svg */
  constructor(svg) {
    this.svg = svg;
    this.fragment = document.createDocumentFragment();
    this.d = "";
    this.fillStyle = this.strokeStyle = "none";
    this.lineWidth = 1;
    this.font = "400 13px sans-serif";
    this.textAlign = "left";
    this.textBaseline = "alphabetic";
  }

  /** Show the drawing and remove the earlier one. */
  show() {
    this.svg.replaceChildren(this.fragment);
  }

  beginPath() {
    this.d = "";
  }

  /**
   * @param {number} x
   * @param {number} y
   */
  moveTo(x, y) {
    this.d += `M${round(x)} ${round(y)}`;
  }

  /**
   * @param {number} x
   * @param {number} y
   */
  lineTo(x, y) {
    this.d += `${this.d ? "L" : "M"}${round(x)} ${round(y)}`;
  }

  closePath() {
    this.d += "Z";
  }

  /**
   * @param {number} x
   * @param {number} y
   * @param {number} r
   * @param {number} from
   * @param {number} to
   */
  arc(x, y, r, from, to) {
    const at = (/** @type {number} */ angle) => `${round(x + r * Math.cos(angle))} ${round(y + r * Math.sin(angle))}`;
    const middle = (from + to) / 2; // two arcs: a full circle ends at its start
    this.d += `M${at(from)}`;
    for (const end of [middle, to]) this.d += `A${round(r)} ${round(r)} 0 0 1 ${at(end)}`;
  }

  stroke() {
    this.add("path", {
      d: this.d, fill: "none", stroke: this.strokeStyle, "stroke-width": this.lineWidth,
      "stroke-linejoin": "round",
    });
  }

  fill() {
    this.add("path", { d: this.d, fill: this.fillStyle });
  }

  /** @param {string} text */
  measureText(text) {
    const c = contextOf(measuring);
    c.font = this.font;
    return c.measureText(text);
  }

  /**
   * @param {string} text
   * @param {number} x
   * @param {number} y
   */
  fillText(text, x, y) {
    this.text(text, x, y, { fill: this.fillStyle });
  }

  /**
   * Draw the outline of a text that is filled afterwards.
   * @param {string} text
   * @param {number} x
   * @param {number} y
   */
  strokeText(text, x, y) {
    const rim = { fill: "none", stroke: this.strokeStyle, "stroke-width": this.lineWidth };
    this.text(text, x, y, { ...rim, "stroke-linejoin": "round" });
  }

  /**
   * @param {string} text
   * @param {number} x
   * @param {number} y
   * @param {Record<string, string | number>} attributes
   */
  text(text, x, y, attributes) {
    const [weight, size] = this.font.split(/ |px/);
    const down = BASELINE[this.textBaseline] * Number(size);
    const element = this.add("text", {
      x: round(x), y: round(y + down), "font-size": size, "font-weight": weight,
      "text-anchor": ANCHOR[this.textAlign], ...attributes,
    });
    element.textContent = text;
  }

  /**
   * @param {string} name
   * @param {Record<string, string | number>} attributes
   */
  add(name, attributes) {
    const element = document.createElementNS(this.svg.namespaceURI, name);
    for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, String(value));
    this.fragment.append(element);
    return element;
  }
}
