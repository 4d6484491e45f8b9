// The whole timeline as a strip with the visible window, while the page is zoomed. A pointer moves the
// window; keys that move the disk beyond the window move it too.

import { positionAt, secondsAt } from "./angle_map.js";
import { byId } from "./dom.js";
import { coloursOf } from "./picture.js";
import { SvgContext } from "./svg.js";
import { partAround } from "./windows.js";

/** @import { View } from "../types" */
/** @import { Data } from "./data.js" */
/** @import { ViewState } from "./view_state.js" */

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
    const zooming = byId("zooming");
    if (view.zoom === 0 && zooming.contains(document.activeElement)) byId("slider").focus();
    zooming.hidden = view.zoom === 0;
    byId("tools").classList.toggle("zoomed", view.zoom > 0);
    if (view.zoom === 0) return;
    this.draw();
    if (this.dragOffset === null) this.placeWindow(view.start_s, view.end_s);
  }

  get whole() {
    return /** @type {View} */ (this.data.whole); // it is loaded before any view is shown
  }

  /**
   * Set the window's frame (s).
   * @param {number} start
   * @param {number} end
   */
  placeWindow(start, end) {
    const [from, to] = [start, end].map((moment) => positionAt(this.whole, moment));
    this.box.style.left = `${100 * from}%`;
    this.box.style.width = `${100 * (to - from)}%`;
  }

  draw() {
    const { width, height } = this.element.getBoundingClientRect();
    if (width === 0) return;
    const colours = coloursOf(this.element);
    const c = new SvgContext(byId("strip-curve"));
    const { level } = this.whole;
    c.beginPath();
    c.moveTo(0, height);
    level.forEach((one, i) => {
      if (i % 4 === 0) c.lineTo((width * i) / (level.length - 1), height * (1 - 0.95 * (one ?? 0)));
    });
    c.lineTo(width, height);
    c.fillStyle = colours.edge;
    c.fill();
    c.show();
  }

  // --- pointer -----------------------------------------------------------------------------------

  /**
   * Return the time (s) under a pointer.
   * @param {PointerEvent} event
   */
  momentUnder({ clientX }) {
    const { left, width } = this.element.getBoundingClientRect();
    return secondsAt(this.whole, (clientX - left) / width);
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
