// The page within an article (`embed.js`): reports to it, colours and language from it, and vertical swipes and
// the wheel scroll the article.

import { byId } from "./dom.js";
import { eventText, positionText } from "./descriptions.js";

/** @import { Info, ReadOut, TimelineEvent, View } from "../types" */

const COLOURS = ["ink", "paper", "soft", "groove"];
const SLOP_PX = 6; // movement that tells a drag from a swipe of the article

/**
 * Follow and report to the article; return what the page calls for each passed event, and at each frame.
 * `redraw()` draws the picture again, `readOut()` is what the page reads out of `view()`.
 * @param {{ info: Info, redraw: () => void, readOut: () => ReadOut, view: () => View }} parts
 */
export function embed({ info, redraw, readOut, view }) {
  const root = document.documentElement;

  /** @param {string} name @param {object} detail */
  const report = (name, detail) => window.parent.postMessage({ overview: name, ...detail }, "*");

  const follow = () => {
    const fields = new URLSearchParams(location.hash.slice(1));
    root.lang = fields.get("lang") ?? "en";
    const title = fields.get("title") ?? info.title;
    document.title = byId("title").textContent = byId("more-title").textContent = title;
    for (const name of COLOURS) {
      const colour = fields.get(name);
      if (colour !== null && window.CSS.supports("color", colour)) root.style.setProperty(`--${name}`, colour);
      else root.style.removeProperty(`--${name}`);
    }
    redraw();
  };

  let last = -1;
  const onmove = () => {
    const { position, moment } = readOut();
    if (position === last) return;
    last = position;
    report("move", { position, time_s: moment, text: positionText(view(), position, info) });
  };
  /** @param {TimelineEvent} event */
  const onenter = (event) => {
    const { kind, label, time_s } = event;
    report("enter", { kind, label, time_s, text: eventText(event, info) });
  };

  root.classList.add("embedded");
  window.addEventListener("hashchange", follow);
  follow();
  scrollArticle(byId("stage"));
  new ResizeObserver(() => {
    report("height", { height: root.scrollHeight > window.innerHeight + 1 ? root.scrollHeight : 0 });
  }).observe(document.body);
  return { onenter, onmove };
}

/**
 * Hold a finger's touch back until it drags sideways or taps, since a vertical swipe belongs to the article;
 * leave the wheel to the article, too.
 * @param {HTMLElement} element
 */
function scrollArticle(element) {
  /** @type {PointerEvent | null} */
  let held = null;
  let isOurs = false; // while the held touch is sent

  const pass = () => {
    if (!held) return;
    const event = new window.PointerEvent("pointerdown", held);
    held = null;
    isOurs = true;
    element.dispatchEvent(event);
    isOurs = false;
  };
  const listen = (/** @type {string} */ type, /** @type {(event: any) => void} */ handle) =>
    element.addEventListener(type, handle, { capture: true });

  listen("pointerdown", (event) => {
    if (isOurs || event.pointerType !== "touch" || !event.isPrimary) return;
    event.stopImmediatePropagation();
    held = event;
  });
  listen("pointermove", (event) => {
    const down = held;
    if (down === null || down.pointerId !== event.pointerId) return;
    const [x, y] = [Math.abs(event.clientX - down.clientX), Math.abs(event.clientY - down.clientY)];
    if (x > SLOP_PX && x > y) pass();
    else if (y > SLOP_PX) held = null;
  });
  listen("pointerup", (event) => held?.pointerId === event.pointerId && pass());
  listen("pointercancel", () => {
    held = null;
  });
  // a part of the element had the touch until it was sent to the element
  listen("lostpointercapture", (event) => event.target !== element && event.stopImmediatePropagation());
  listen("wheel", (event) => {
    if (!event.ctrlKey && !event.shiftKey && Math.abs(event.deltaY) >= Math.abs(event.deltaX)) {
      event.stopImmediatePropagation();
    }
  });
}
