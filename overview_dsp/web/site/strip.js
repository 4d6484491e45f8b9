// The whole timeline as a strip: where the shown window lies in it, and how the score went. A finger
// moves the window; keys and screen readers have the buttons "earlier" and "later" for that.

import { placeAt, secondsAt } from "./angle_map.js";
import { by } from "./dom.js";
import { coloursOf } from "./picture.js";
import { SvgContext } from "./svg.js";
import { partAbout, partOf } from "./windows.js";
import { scoresOf } from "./words.js";

/** @import { View } from "../types" */
/** @import { Data } from "./data.js" */
/** @import { Shown } from "./shown.js" */

const FONT_PX = 13;

export class Strip {
  /**
   * @param {Data} data
   * @param {Shown} shown
   */
  constructor(data, shown) {
    this.data = data;
    this.shown = shown;
    this.element = by("strip");
    this.box = by("strip-window");
    /** @type {View | null} */
    this.whole = null; // the view of the whole
    /** @type {number | null} */
    this.held = null; // how far (s) a finger is from the window's middle
    this.element.addEventListener("pointerdown", (/** @type {PointerEvent} */ event) => this.down(event));
    this.element.addEventListener("pointermove", (/** @type {PointerEvent} */ event) => this.move(event));
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
      this.element.addEventListener(end, () => this.up());
    }
    new ResizeObserver(() => this.draw()).observe(this.element);
  }

  /**
   * Another window is shown, or the same.
   * @param {View} view
   */
  show(view) {
    const { info } = this.data;
    if (view.zoom === 0) this.whole = view;
    const stale = this.whole?.end_s !== info.duration_s;
    const scores = this.whole !== null && scoresOf(this.whole).length > 0;
    this.element.hidden = view.zoom === 0 && !scores;
    this.element.classList.toggle("whole", view.zoom === 0);
    if (view.zoom === 0) this.draw();
    else if (stale) this.fetch();
    if (this.held === null) this.place(view.start_s, view.end_s);
  }

  /** What the strip shows: until it has come, its length alone. */
  get drawn() {
    return this.whole ?? { start_s: 0, end_s: this.data.info.duration_s };
  }

  async fetch() {
    this.whole = await this.data.view(partOf(this.shown.windows, 0)).catch(() => /** @type {View | null} */ (null));
    this.draw();
    const { start_s, end_s } = this.shown.view;
    if (this.held === null) this.place(start_s, end_s);
  }

  /**
   * Put the window's frame there (s).
   * @param {number} start
   * @param {number} end
   */
  place(start, end) {
    const [from, to] = [start, end].map((moment) => placeAt(this.drawn, moment));
    this.box.style.left = `${100 * from}%`;
    this.box.style.width = `${100 * (to - from)}%`;
  }

  draw() {
    const { width, height } = this.element.getBoundingClientRect();
    if (this.whole === null || width === 0) return;
    const colours = coloursOf(this.element);
    const c = new SvgContext(by("strip-curve"));
    const { level } = this.whole;
    c.beginPath();
    c.moveTo(0, height);
    level.forEach((one, i) => {
      if (i % 4 === 0) c.lineTo((width * i) / (level.length - 1), height * (1 - 0.95 * one));
    });
    c.lineTo(width, height);
    c.fillStyle = colours.line;
    c.fill();
    const em = parseFloat(getComputedStyle(document.documentElement).fontSize) / 16;
    c.font = `600 ${FONT_PX * em}px sans-serif`;
    c.fillStyle = colours.ink;
    c.textAlign = "left";
    c.textBaseline = "top";
    const scores = scoresOf(this.whole);
    scores.forEach(({ place, text }, i) => {
      const room = width * ((scores[i + 1]?.place ?? 1) - place) - 6;
      if (c.measureText(text).width < room) c.fillText(text, width * place + 4, 4);
      if (i === 0) return;
      c.beginPath();
      c.moveTo(width * place, 0);
      c.lineTo(width * place, height);
      c.strokeStyle = colours.soft;
      c.stroke();
    });
    c.show();
  }

  // --- a finger ---------------------------------------------------------------------------------

  /**
   * The moment (s) under a pointer.
   * @param {PointerEvent} event
   */
  under({ clientX }) {
    const { left, width } = this.element.getBoundingClientRect();
    return secondsAt(this.drawn, (clientX - left) / width);
  }

  /** @param {PointerEvent} event */
  down(event) {
    const { view } = this.shown;
    if (event.button !== 0 || view.zoom === 0) return;
    this.element.setPointerCapture(event.pointerId);
    const moment = this.under(event);
    const inside = moment > view.start_s && moment < view.end_s;
    this.held = inside ? moment - (view.start_s + view.end_s) / 2 : 0;
    this.move(event);
  }

  /** @param {PointerEvent} event */
  move(event) {
    if (this.held === null) return;
    const { windows, view } = this.shown;
    const { duration_s } = this.data.info;
    const half = (view.end_s - view.start_s) / 2;
    const middle = Math.min(Math.max(this.under(event) - this.held, half), duration_s - half);
    this.place(middle - half, middle + half);
    this.shown.toward(partAbout(windows, view.zoom, middle));
  }

  up() {
    if (this.held === null) return;
    this.held = null;
    const { start_s, end_s } = this.shown.view;
    this.place(start_s, end_s);
  }
}
