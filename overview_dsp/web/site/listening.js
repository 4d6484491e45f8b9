// What the page listens to: finger, keys, buttons, settings, and the browser's own changes.

import { by } from "./dom.js";
import { EventList } from "./event_list.js";
import { HELP, listenToKeys } from "./keys.js";
import { bindSettings } from "./settings.js";
import { listenToTouch } from "./touch.js";
import { eventAt } from "./words.js";

/** @import { TimelineEvent } from "../types" */
/** @import { Page } from "./page.js" */

/**
 * Listen for a page; its list of events.
 * @param {Page} page
 */
export function listen(page) {
  const element = by("slider");
  const { hand, shown, walk } = page;
  const onfirst = () => page.start();
  listenToTouch(element, hand, {
    placeOf: (event, first) => page.picture.placeUnder(event, first),
    ontap: (x, y) => page.tapped(x, y),
    onpinch: (factor, x, over) => page.pinch.to(factor, x, over),
    onfirst,
  });
  /** @type {((event: TimelineEvent) => void) | null} */
  const watch = page.film === null ? null : (event) => page.served.watch(event);
  listenToKeys(element, { walk, shown, open: (name) => page.open(name) }, onfirst);
  element.addEventListener("focus", () => walk.summary());
  element.addEventListener("wheel", (/** @type {WheelEvent} */ event) => {
    event.preventDefault();
    shown.wheel(event);
  }, { passive: false });
  hand.onchange = () => {
    if (hand.holder === "keys") page.last = eventAt(page.view, page.place) ?? page.last;
    page.wake();
  };
  /** @type {(id: string, act: () => void) => void} */
  const click = (id, act) => by(id).addEventListener("click", () => {
    page.start();
    act();
  });
  click("previous", () => walk.event(-1));
  click("next", () => walk.event(1));
  click("tap", () => walk.tap());
  click("run", () => page.playback.toggle());
  click("list", () => page.open("events"));
  by("twist").addEventListener("click", () => page.toggleTwist());
  by("in").addEventListener("click", () => shown.zoom(1));
  by("out").addEventListener("click", () => shown.zoom(-1));
  by("earlier").addEventListener("click", () => shown.beside(-1));
  by("later").addEventListener("click", () => shown.beside(1));
  by("settings").addEventListener("click", () => by("dialog").showModal());
  const terms = HELP.flatMap(([keys, act]) => [term("dt", keys), term("dd", act)]);
  by("keys").replaceChildren(...terms);
  by("calibrate").addEventListener("click", () => page.calibrate());
  bindSettings(by("dialog").querySelector("form"), page.settings, () => page.apply());
  document.addEventListener("visibilitychange", () => {
    if (!document.hidden) page.comeBack();
    else if (!page.twist.on) page.leave();
  });
  window.addEventListener("pagehide", () => page.leave());
  new ResizeObserver(() => {
    page.picture.resize();
    page.wake();
  }).observe(by("canvas"));
  // large text scrolls the page under a finger that is about to come
  document.addEventListener("scroll", () => page.picture.locate(), { passive: true });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
    page.picture.redraw();
    page.strip.draw();
    page.tellAbout();
    page.wake();
  });
  return new EventList(page.info, walk, (event) => page.goTo(event.place, event), watch);
}

/**
 * @param {string} name
 * @param {string} text
 */
function term(name, text) {
  const element = document.createElement(name);
  element.textContent = text;
  return element;
}
