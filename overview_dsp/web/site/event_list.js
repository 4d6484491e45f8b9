// The events of a window as a list of buttons: each is gone to, and watched where there is a film.

import { by } from "./dom.js";
import { isDetail } from "./layer.js";
import { eventText, momentText, summaryText } from "./words.js";

/** @import { Info, TimelineEvent, View } from "../types" */
/** @import { Walk } from "./walk.js" */

const MOST = 500;

export class EventList {
  /**
   * `go(event)`, `watch(event)` (or null without a film); `walk` has first, highest, ...
   * @param {Info} info
   * @param {Walk} walk
   * @param {(event: TimelineEvent) => void} go
   * @param {((event: TimelineEvent) => void) | null} watch
   */
  constructor(info, walk, go, watch) {
    this.info = info;
    this.go = go;
    this.watch = watch;
    for (const button of [...by("events").querySelectorAll("[data-go]")]) {
      /** @type {"first" | "highest" | "lowest" | "last"} */
      const where = button.dataset.go;
      button.addEventListener("click", () => {
        by("events").close();
        by("slider").focus();
        walk[where]();
      });
    }
  }

  /** @param {View} view */
  open(view) {
    const events = view.events.filter(({ kind }) => !isDetail(this.info, kind));
    by("events-summary").textContent = summaryText(view, this.info);
    by("events-list").replaceChildren(...events.slice(0, MOST).map((event) => this.item(event)));
    by("events").showModal();
    by("events-title").focus();
  }

  /** @param {TimelineEvent} event */
  item(event) {
    const item = document.createElement("li");
    const told = `${momentText(event.time_s, this.info)}, ${eventText(event, this.info)}`;
    item.append(this.button(told, "go", () => this.go(event)));
    if (this.watch !== null) {
      const button = this.button("Watch", "watch", () => this.watch(event));
      button.setAttribute("aria-label", `Watch ${told}`);
      item.append(button);
    }
    return item;
  }

  /**
   * @param {string} text
   * @param {string} name
   * @param {() => void} act
   */
  button(text, name, act) {
    const button = document.createElement("button");
    button.type = "button";
    button.className = name;
    button.textContent = text;
    button.addEventListener("click", () => {
      by("events").close();
      act();
    });
    return button;
  }
}
