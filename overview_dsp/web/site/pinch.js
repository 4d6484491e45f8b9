// Zoom by two fingers. The picture follows at once; the surface follows in steps. A server makes any
// window; a static folder offers the nearest of its windows.

import { croppedTo, partBetween, partNearest } from "./windows.js";
import { secondsAt } from "./angle_map.js";

/** @import { Data } from "./data.js" */
/** @import { Picture } from "./picture.js" */
/** @import { ViewState } from "./view_state.js" */

const STEP = 1.25; // change of scale that loads another window

export class Pinch {
  /**
   * @param {ViewState} viewState
   * @param {Picture} picture
   * @param {Data} data
   */
  constructor(viewState, picture, data) {
    this.viewState = viewState;
    this.picture = picture;
    this.data = data;
    /** @type {{ length: number, moment: number } | null} */
    this.origin = null; // length and time under the fingers at the start
  }

  /**
   * Zoom by `factor` since the start, around x; `over`: the fingers were lifted.
   * @param {number} factor
   * @param {number} x
   * @param {boolean} over
   */
  to(factor, x, over) {
    const { viewState, picture } = this;
    const { windows, view } = viewState;
    const position = picture.positionOf(x);
    this.origin ??= { length: view.end_s - view.start_s, moment: secondsAt(view, position) };
    const longest = windows[0].end_s;
    const last = windows[windows.length - 1];
    const shortest = last.end_s - last.start_s;
    const length = Math.min(Math.max(this.origin.length / factor, shortest), longest);
    const start = Math.min(Math.max(this.origin.moment - position * length, 0), longest - length);
    /** @type {[number, number]} */
    const target = [start, start + length];
    if (over) this.origin = null;
    const now = view.end_s - view.start_s;
    if (!viewState.canShowAnyWindow) viewState.goToLatest(partNearest(windows, target));
    else if (over || now / length > STEP || length / now > STEP) {
      viewState.goToLatest(partBetween(windows, target));
    }
    this.preview(over ? null : target);
  }

  /**
   * Draw the known part of a window before it is loaded; null: the active window.
   * @param {[number, number] | null} window
   */
  preview(window) {
    const { view } = this.viewState;
    const inside = window && window[0] >= view.start_s && window[1] <= view.end_s;
    const source = inside ? view : this.data.whole;
    this.picture.show(window && source ? croppedTo(source, window) : view);
  }
}
