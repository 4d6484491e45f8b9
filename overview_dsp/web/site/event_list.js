// The events of a window as a list of buttons, which move the disk or play the film.

import { byId } from "./dom.js";
import { isDetail } from "./layer.js";
import { eventText, momentText, summaryText } from "./descriptions.js";

/** @import { Info, TimelineEvent, View } from "../types" */
/** @import { Navigation } from "./navigation.js" */

const MOST = 500; // maximum number of listed events

export class EventList {
  /**
   * `go(event)` and `watch(event)` handle the buttons; `watch` is null without a film.
   * @param {Info} info
   * @param {Navigation} navigation
   * @param {(event: TimelineEvent) => void} go
   * @param {((event: TimelineEvent) => void) | null} watch
   */
  constructor(info, navigation, go, watch) {
    this.info = info;
    this.go = go;
    this.watch = watch;
    /** @type {[string, () => void][]} */
    const targets = [
      ["first", () => navigation.toFirst()], ["highest", () => navigation.toHighest()],
      ["lowest", () => navigation.toLowest()], ["last", () => navigation.toLast()],
    ];
    for (const [target, move] of targets) {
      byId("events").querySelector(`[data-go=${target}]`)?.addEventListener("click", () => {
        byId("events").close();
        move();
        byId("slider").focus();
      });
    }
  }

  /** @param {View} view */
  open(view) {
    const events = view.events.filter(({ kind }) => !isDetail(this.info, kind));
    byId("events-summary").textContent = summaryText(view, this.info);
    byId("events-list").replaceChildren(...events.slice(0, MOST).map((event) => this.item(event)));
    byId("events").showModal();
    byId("events-title").focus();
  }

  /** @param {TimelineEvent} event */
  item(event) {
    const item = document.createElement("li");
    const description = `${momentText(event.time_s, this.info)}, ${eventText(event, this.info)}`;
    item.append(this.button(description, "go", () => this.go(event)));
    const { watch } = this;
    if (watch !== null) {
      const button = this.button("Watch", "watch", () => watch(event));
      button.setAttribute("aria-label", `Watch ${description}`);
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
      byId("events").close();
      act();
    });
    return button;
  }
}
