// The whole timeline as a strip with the visible window and the scores of a match. A pointer moves
// the window; for keys and screen readers there are the buttons "Earlier" and "Later".

import { positionAt, secondsAt } from "./angle_map.js";
import { byId } from "./dom.js";
import { coloursOf } from "./picture.js";
import { SvgContext } from "./svg.js";
import { partAround, partOf } from "./windows.js";
import { scoresOf } from "./descriptions.js";

/** @import { View } from "../types" */
/** @import { Data } from "./data.js" */
/** @import { ViewState } from "./view_state.js" */

const FONT_PX = 13;

export class Strip {
  /**
   * @param {Data} data
   * @param {ViewState} viewState
   */
  constructor(data, viewState) {
    this.data = data;
    this.viewState = viewState;
    this.element = byId("strip");
    this.box = byId("strip-window");
    /** @type {View | null} */
    this.whole = null; // view of the whole timeline
    /** @type {number | null} */
    this.dragOffset = null; // distance (s) from the window's middle to the pointer
    this.element.addEventListener("pointerdown", (/** @type {PointerEvent} */ event) => this.down(event));
    this.element.addEventListener("pointermove", (/** @type {PointerEvent} */ event) => this.move(event));
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) {
      this.element.addEventListener(end, () => this.up());
    }
    new ResizeObserver(() => this.draw()).observe(this.element);
  }

  /**
   * Update the strip for a view.
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
    if (this.dragOffset === null) this.placeWindow(view.start_s, view.end_s);
  }

  /** The view of the strip; before it is loaded, its duration alone. */
  get drawn() {
    return this.whole ?? { start_s: 0, end_s: this.data.info.duration_s };
  }

  async fetch() {
    this.whole = await this.data.view(partOf(this.viewState.windows, 0)).catch(() => /** @type {View | null} */ (null));
    this.draw();
    const { start_s, end_s } = this.viewState.view;
    if (this.dragOffset === null) this.placeWindow(start_s, end_s);
  }

  /**
   * Set the window's frame (s).
   * @param {number} start
   * @param {number} end
   */
  placeWindow(start, end) {
    const [from, to] = [start, end].map((moment) => positionAt(this.drawn, moment));
    this.box.style.left = `${100 * from}%`;
    this.box.style.width = `${100 * (to - from)}%`;
  }

  draw() {
    const { width, height } = this.element.getBoundingClientRect();
    if (this.whole === null || width === 0) return;
    const colours = coloursOf(this.element);
    const c = new SvgContext(byId("strip-curve"));
    const { level } = this.whole;
    c.beginPath();
    c.moveTo(0, height);
    level.forEach((one, i) => {
      if (i % 4 === 0) c.lineTo((width * i) / (level.length - 1), height * (1 - 0.95 * (one ?? 0)));
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
    scores.forEach(({ position, text }, i) => {
      const room = width * ((scores[i + 1]?.position ?? 1) - position) - 6;
      if (c.measureText(text).width < room) c.fillText(text, width * position + 4, 4);
      if (i === 0) return;
      c.beginPath();
      c.moveTo(width * position, 0);
      c.lineTo(width * position, height);
      c.strokeStyle = colours.soft;
      c.stroke();
    });
    c.show();
  }

  // --- pointer -----------------------------------------------------------------------------------

  /**
   * Return the time (s) under a pointer.
   * @param {PointerEvent} event
   */
  momentUnder({ clientX }) {
    const { left, width } = this.element.getBoundingClientRect();
    return secondsAt(this.drawn, (clientX - left) / width);
  }

  /** @param {PointerEvent} event */
  down(event) {
    const { view } = this.viewState;
    if (event.button !== 0 || view.zoom === 0) return;
    this.element.setPointerCapture(event.pointerId);
    const moment = this.momentUnder(event);
    const inside = moment > view.start_s && moment < view.end_s;
    this.dragOffset = inside ? moment - (view.start_s + view.end_s) / 2 : 0;
    this.move(event);
  }

  /** @param {PointerEvent} event */
  move(event) {
    if (this.dragOffset === null) return;
    const { windows, view } = this.viewState;
    const { duration_s } = this.data.info;
    const half = (view.end_s - view.start_s) / 2;
    const middle = Math.min(Math.max(this.momentUnder(event) - this.dragOffset, half), duration_s - half);
    this.placeWindow(middle - half, middle + half);
    this.viewState.goToLatest(partAround(windows, view.zoom, middle));
  }

  up() {
    if (this.dragOffset === null) return;
    this.dragOffset = null;
    const { start_s, end_s } = this.viewState.view;
    this.placeWindow(start_s, end_s);
  }
}
