// Finger, pen and mouse: drag, tap, release; two fingers pinch.

const TAP_MS = 250;
const TAP_PX = 10;

/** @import { Hand } from "./hand.js" */

/**
 * @typedef {object} TouchMeans
 * @property {(pointer: { clientX: number, clientY: number }, first?: boolean) => number} placeOf
 * @property {(x: number, y: number) => void} ontap
 * @property {(factor: number, x: number, over: boolean) => void} onpinch
 * @property {() => void} onfirst
 */

/**
 * `placeOf(event, first)` is the place (0 to 1) of a pointer, `first` where it came down;
 * `ontap(x, y)` is called after a short touch; `onpinch(factor, x, over)` while two fingers spread or
 * close about x, `factor` since they came down; `onfirst()` at every touch, in which sound may be
 * started.
 * @param {HTMLElement} element
 * @param {Pick<Hand, "hold" | "release">} hand
 * @param {TouchMeans} means
 */
export function listenToTouch(element, hand, { placeOf, ontap, onpinch, onfirst }) {
  /** @type {Map<number, PointerEvent>} */
  const fingers = new Map();
  /** @type {{ x: number, y: number, time: number, tap: boolean } | null} */
  let down = null;
  let spread = 0;

  element.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    onfirst();
    element.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, event);
    if (fingers.size === 1) {
      down = { x: event.clientX, y: event.clientY, time: event.timeStamp, tap: true };
      hand.hold("touch", placeOf(event, true), event.timeStamp);
    } else if (fingers.size === 2) {
      down = null;
      hand.release("touch", event.timeStamp);
      spread = distance(fingers);
    }
  });

  /** @param {boolean} over */
  const pinched = (over) => {
    const [a, b] = [...fingers.values()];
    onpinch(distance(fingers) / Math.max(spread, 1), (a.clientX + b.clientX) / 2, over);
  };

  element.addEventListener("pointermove", (event) => {
    if (!fingers.has(event.pointerId)) return;
    fingers.set(event.pointerId, event);
    if (fingers.size === 1 && down) {
      if (Math.hypot(event.clientX - down.x, event.clientY - down.y) > TAP_PX) down.tap = false;
      const seen = event.getCoalescedEvents?.() ?? [];
      for (const one of seen.length > 0 ? seen : [event]) {
        hand.hold("touch", placeOf(one), one.timeStamp);
      }
    } else if (fingers.size === 2) {
      pinched(false);
    }
  });

  /** @param {PointerEvent} event */
  const up = (event) => {
    if (!fingers.has(event.pointerId)) return;
    if (fingers.size === 2) pinched(true);
    fingers.delete(event.pointerId);
    if (!down) return;
    const tapped = down.tap && event.type === "pointerup" && event.timeStamp - down.time < TAP_MS;
    if (tapped) ontap(event.clientX, event.clientY);
    hand.release("touch", event.timeStamp);
    down = null;
  };
  element.addEventListener("pointerup", up);
  element.addEventListener("pointercancel", up);
  element.addEventListener("lostpointercapture", up);
  element.addEventListener("contextmenu", (event) => event.preventDefault());
}

/** @param {Map<number, PointerEvent>} fingers */
function distance(fingers) {
  const [a, b] = [...fingers.values()];
  return Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY);
}
