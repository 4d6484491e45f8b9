// Pointers: drag, tap and release; two fingers pinch.

const TAP_MS = 250;
const TAP_PX = 10;

/** @import { CombinedInput } from "./combined_input.js" */

/**
 * @typedef {object} TouchHandlers
 * @property {(pointer: { clientX: number, clientY: number }, first?: boolean) => number} positionOf
 * @property {(x: number, y: number) => void} ontap
 * @property {(factor: number, x: number, over: boolean) => void} onpinch
 * @property {() => void} onfirst
 */

/**
 * `positionOf(event, first)` returns the position (0 to 1) of a pointer, `first` at its start.
 * `ontap(x, y)` is called after a short touch, `onpinch(factor, x, over)` while two fingers move
 * (`over`: at their end), and `onfirst()` at every touch: browsers allow sound to start then.
 * @param {HTMLElement} element
 * @param {Pick<CombinedInput, "moveTo" | "release">} input
 * @param {TouchHandlers} handlers
 */
export function listenToTouch(element, input, { positionOf, ontap, onpinch, onfirst }) {
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
      input.moveTo("touch", positionOf(event, true), event.timeStamp);
    } else if (fingers.size === 2) {
      down = null;
      input.release("touch", event.timeStamp);
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
        input.moveTo("touch", positionOf(one), one.timeStamp);
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
    input.release("touch", event.timeStamp);
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
