// Event listeners of the page: stage and slider, buttons, and what the browser changes.

import { byId, made, on } from "./dom.js";
import { listenToKeys } from "./keys.js";
import { listenToTouch } from "./touch.js";
import { HELP } from "./page_words.js";

/** @import { Elements } from "../types" */
/** @import { CombinedInput } from "./combined_input.js" */
/** @import { Navigation } from "./navigation.js" */
/** @import { Picture } from "./picture.js" */
/** @import { Pinch } from "./pinch.js" */
/** @import { ViewState } from "./view_state.js" */

/**
 * Let pointers, wheel, keys and screen readers move the input; `start()` is called before each of them.
 * @param {{ input: CombinedInput, navigation: Navigation, picture: Picture, pinch: Pinch, viewState: ViewState,
 *   start: () => void, open: (name: string) => void, ontap: (x: number, y: number) => void,
 *   reading: () => number }} parts
 */
export function listenToStage({ input, navigation, picture, pinch, viewState, start, open, ontap, reading }) {
  const element = byId("stage");
  const slider = byId("slider");
  listenToTouch(element, input, {
    positionOf: (event, begins) => picture.positionUnder(event, begins),
    ontap,
    onpinch: (factor, x, over) => pinch.to(factor, x, over),
    onfirst: start,
  });
  listenToKeys(slider, { navigation, open }, start);
  slider.addEventListener("focus", () => navigation.speakSummary());
  // a pointer needs no frame around the picture, keys do
  const setPointing = (/** @type {boolean} */ isPointing) => element.classList.toggle("pointing", isPointing);
  slider.addEventListener("keydown", () => setPointing(false));
  element.addEventListener("pointerdown", () => {
    setPointing(true);
    slider.focus({ preventScroll: true });
  });
  element.addEventListener("mousedown", (event) => event.preventDefault()); // the slider keeps the focus
  // after the finger: buttons that hold the disk have no release of their own
  element.addEventListener("pointerup", ({ button }) => button === 0 && input.release("keys"));
  // a screen reader changes the value by gestures
  slider.addEventListener("input", () => {
    start();
    navigation.step(Math.sign(Number(slider.value) / 100 - reading()));
  });
  element.addEventListener("wheel", (/** @type {WheelEvent} */ event) => {
    event.preventDefault();
    viewState.wheel(event);
  }, { passive: false });
}

/**
 * Connect the buttons: `acts` by their id, those of `starting` start the sound first; buttons that name another
 * by `data-does` click it, or act by `moves`.
 * @param {{ starting: Partial<Record<keyof Elements, () => void>>, acts: Partial<Record<keyof Elements, () => void>>,
 *   moves: Record<string, () => void>, start: () => void }} parts
 */
export function listenToButtons({ starting, acts, moves, start }) {
  const startAnd = (/** @type {() => void} */ act) => () => {
    start();
    act();
  };
  const entries = [
    ...Object.entries(starting).map(([id, act]) => [id, startAnd(act)]), ...Object.entries(acts),
  ];
  for (const [id, act] of /** @type {[keyof Elements, () => void][]} */ (entries)) on(id, "click", act);
  // also buttons that have no room on a small screen
  for (const button of /** @type {NodeListOf<HTMLElement>} */ (document.querySelectorAll("[data-does]"))) {
    button.addEventListener("click", () => {
      byId("dialog").close();
      const name = button.dataset.does ?? "";
      start();
      if (Object.hasOwn(moves, name)) moves[name]();
      else document.getElementById(name)?.click();
    });
  }
  const terms = HELP.flatMap(([keys, act]) => [made("dt", {}, keys), made("dd", {}, act)]);
  byId("keys").replaceChildren(...terms);
  for (const button of document.querySelectorAll("nav > button")) button.removeAttribute("disabled");
}

/**
 * Follow the browser: `onhide()` and `onshow()` of the page, the size of the picture (`onpicture`) and of window or
 * text (`onsize`), scrolling, and a change of colours.
 * @param {Record<"onhide" | "onshow" | "onleave" | "onpicture" | "onsize" | "onscroll" | "oncolours",
 *   () => void>} parts
 */
export function listenToBrowser({ onhide, onshow, onleave, onpicture, onsize, onscroll, oncolours }) {
  document.addEventListener("visibilitychange", () => (document.hidden ? onhide() : onshow()));
  window.addEventListener("pagehide", onleave);
  new ResizeObserver(onpicture).observe(byId("canvas"));
  const resized = new ResizeObserver(onsize);
  for (const one of document.querySelectorAll("html, nav")) resized.observe(one);
  // with large text the page may scroll before a touch
  document.addEventListener("scroll", onscroll, { passive: true });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", oncolours);
}
