// Two fingers zoom: the picture follows them at once; what is under the hand goes along in gentle
// steps where a server makes any window, else to the nearest of the folder's windows.

import { croppedTo, partBetween, partNearest } from "./windows.js";
import { secondsAt } from "./angle_map.js";

/** @import { View } from "../types" */
/** @import { Picture } from "./picture.js" */
/** @import { Shown } from "./shown.js" */

const STEP = 1.25; // as much closer or farther is another window

export class Pinch {
  /**
   * `whole()` is the view of the whole timeline, or null.
   * @param {Shown} shown
   * @param {Picture} picture
   * @param {() => View | null} whole
   */
  constructor(shown, picture, whole) {
    this.shown = shown;
    this.picture = picture;
    this.whole = whole;
    /** @type {{ length: number, moment: number } | null} */
    this.from = null; // what was under the fingers as they came down
  }

  /**
   * The fingers have spread by `factor` since they came down, about x; `over`: they have gone.
   * @param {number} factor
   * @param {number} x
   * @param {boolean} over
   */
  to(factor, x, over) {
    const { shown, picture } = this;
    const { windows } = shown;
    const { view } = shown;
    const place = picture.placeOf(x);
    this.from ??= { length: view.end_s - view.start_s, moment: secondsAt(view, place) };
    const whole = windows[0].end_s;
    const closest = windows.at(-1).end_s - windows.at(-1).start_s;
    const length = Math.min(Math.max(this.from.length / factor, closest), whole);
    const start = Math.min(Math.max(this.from.moment - place * length, 0), whole - length);
    /** @type {[number, number]} */
    const wanted = [start, start + length];
    if (over) this.from = null;
    const now = view.end_s - view.start_s;
    if (!shown.anywhere) shown.toward(partNearest(windows, wanted));
    else if (over || now / length > STEP || length / now > STEP) {
      shown.toward(partBetween(windows, wanted));
    }
    this.preview(over ? null : wanted);
  }

  /**
   * Draw what is known of a window before it is there; null: what is under the hand.
   * @param {[number, number] | null} window
   */
  preview(window) {
    const { view } = this.shown;
    const inside = window && window[0] >= view.start_s && window[1] <= view.end_s;
    const known = inside ? view : this.whole();
    this.picture.show(window && known ? croppedTo(known, window) : view);
  }
}
