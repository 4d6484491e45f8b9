// Event listeners of the page: pointers, keys, buttons, settings and browser changes.

import { byId, made, on } from "./dom.js";
import { EventList } from "./event_list.js";
import { listenToKeys } from "./keys.js";
import { bindSettings } from "./settings.js";
import { listenToTouch } from "./touch.js";
import { HELP } from "./page_words.js";

/** @import { Elements, TimelineEvent } from "../types" */
/** @import { Page } from "./page.js" */

/**
 * Add the listeners of a page and return its list of events.
 * @param {Page} page
 */
export function listen(page) {
  const element = byId("stage");
  const slider = byId("slider");
  const { input, viewState, navigation } = page;
  const onfirst = () => page.start();
  listenToTouch(element, input, {
    positionOf: (event, begins) => page.picture.positionUnder(event, begins),
    ontap: (x, y) => page.onTap(x, y),
    onpinch: (factor, x, over) => page.pinch.to(factor, x, over),
    onfirst,
  });
  /** @type {((event: TimelineEvent) => void) | null} */
  const watch = page.film === null ? null : (event) => page.served?.watch(event);
  listenToKeys(slider, { navigation, open: (name) => page.open(name) }, onfirst);
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
    page.start();
    navigation.step(Math.sign(Number(slider.value) / 100 - page.reading));
  });
  element.addEventListener("wheel", (/** @type {WheelEvent} */ event) => {
    event.preventDefault();
    viewState.wheel(event);
  }, { passive: false });
  /** @type {(id: keyof Elements, act: () => void) => void} */
  const click = (id, act) => on(id, "click", () => {
    page.start();
    act();
  });
  /** @type {(direction: number) => unknown} */
  const step = (direction) =>
    (page.settings.steps === "values" && page.info.series
      ? navigation.toValue(direction) : navigation.toEvent(direction));
  click("previous", () => step(-1));
  click("next", () => step(1));
  click("run", () => page.playback.toggle());
  click("list", () => page.open("events"));
  on("twist", "click", () => {
    byId("dialog").close();
    page.toggleTwist();
  });
  on("in", "click", () => navigation.zoom(1));
  on("out", "click", () => navigation.zoom(-1));
  on("whole", "click", () => navigation.showWhole());
  on("all-values", "click", () => {
    byId("dialog").close();
    page.openValues();
  });
  /** @type {Record<string, () => void>} */
  const moves = { tap: () => navigation.tap(), release: () => navigation.release() };
  // also buttons that have no room on a small screen
  for (const button of /** @type {NodeListOf<HTMLElement>} */ (document.querySelectorAll("[data-does]"))) {
    button.addEventListener("click", () => {
      byId("dialog").close();
      const name = button.dataset.does ?? "";
      page.start();
      if (Object.hasOwn(moves, name)) moves[name]();
      else document.getElementById(name)?.click();
    });
  }
  on("settings", "click", () => byId("dialog").showModal());
  const terms = HELP.flatMap(([keys, act]) => [made("dt", {}, keys), made("dd", {}, act)]);
  byId("keys").replaceChildren(...terms);
  on("calibrate", "click", () => page.calibrate());
  bindSettings(byId("settings-form"), page.settings, () => page.apply());
  document.addEventListener("visibilitychange", () => {
    if (!document.hidden) page.resume();
    else if (!page.twist.on) page.pause();
  });
  window.addEventListener("pagehide", () => page.pause());
  new ResizeObserver(() => {
    page.picture.resize();
    viewState.resize();
    page.wake();
  }).observe(byId("canvas"));
  // the window and the size of the text
  const resized = new ResizeObserver(() => page.fit());
  for (const one of document.querySelectorAll("html, nav")) resized.observe(one);
  // with large text the page may scroll before a touch
  document.addEventListener("scroll", () => page.picture.locate(), { passive: true });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
    page.picture.redraw();
    page.strip.draw();
    page.wake();
  });
  for (const button of document.querySelectorAll("nav > button")) button.removeAttribute("disabled");
  return new EventList(page.info, navigation, {
    go: (event) => page.goToEvent(event), watch, hidden: page.picture.hidden, toggle: (kind) => page.toggleKind(kind),
  });
}
