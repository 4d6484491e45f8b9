// The events of the timeline as a list of buttons, which move the disk or play the film. It has all events:
// blocks of them are filled while they are near the visible part.

import { button, byId, made, on } from "./dom.js";
import { chipsOf, markIcon } from "./legend.js";
import { EXTREMES } from "./layer.js";
import { markOf } from "./marks.js";
import { isSameEvent } from "./scores.js";
import { eventText, momentText, summaryText } from "./descriptions.js";
import { eventCount, NOTHING_FOUND, WATCH } from "./page_words.js";

/** @import { Info, TimelineEvent, View } from "../types" */
/** @import { Navigation } from "./navigation.js" */
/** @typedef {{ event: TimelineEvent, text: string, when: string }} Row */

const BLOCK = 40; // events
const ROW_REM = 3.25; // height of a row before it is filled
const NEAR = "600px"; // distance at which blocks are filled

/**
 * Return a text in capitals and without accents, for comparison.
 * @param {string} text
 */
const plain = (text) => text.normalize("NFD").replace(/\p{M}/gu, "").toUpperCase();

/**
 * Return the events of the whole timeline and those that only a window has, without its extremes.
 * @param {View} view
 * @param {View} whole
 */
function allEvents(view, { events }) {
  if (view.number === 0) return events;
  const near = events.filter(({ time_s }) => time_s >= view.start_s - 1 && time_s <= view.end_s + 1);
  const more = view.events.filter((one) => !EXTREMES.has(one.kind) && !near.some((other) => isSameEvent(one, other)));
  return [...events, ...more].sort((a, b) => a.time_s - b.time_s);
}

export class EventList {
  /**
   * `go(event)` and `watch(event)` handle the buttons; `watch` is null without a film. `toggle(kind)`
   * shows or hides the marks of a kind, which are `hidden`.
   * @param {Info} info
   * @param {Navigation} navigation
   * @param {{ go: (event: TimelineEvent) => void, watch: ((event: TimelineEvent) => void) | null,
   *   hidden: Set<string>, toggle: (kind: string) => void }} handlers
   */
  constructor(info, navigation, { go, watch, hidden, toggle }) {
    this.info = info;
    this.go = go;
    this.watch = watch;
    this.hidden = hidden;
    this.toggle = toggle;
    /** @type {Row[]} */
    this.rows = [];
    /** @type {Row[]} */
    this.found = [];
    this.wasBeside = false;
    /** @type {TimelineEvent | null} */
    this.marked = null; // in the list beside the picture
    this.observer = new IntersectionObserver((entries) => {
      for (const { target, isIntersecting } of entries) this.fill(/** @type {HTMLElement} */ (target), isIntersecting);
    }, { root: byId("events"), rootMargin: NEAR });
    on("find", "input", () => this.search());
    on("find", "keydown", (event) => event.key === "Enter" && event.preventDefault());
    /** @type {[string, () => void][]} */
    const targets = [
      ["first", () => navigation.toFirst()], ["highest", () => navigation.toHighest()],
      ["lowest", () => navigation.toLowest()], ["last", () => navigation.toLast()],
    ];
    for (const [target, move] of targets) {
      byId("events").querySelector(`[data-go=${target}]`)?.addEventListener("click", () => {
        this.close();
        move();
        byId("slider").focus();
      });
    }
  }

  /** Whether the list is beside the picture, where the style sheet has room for it. */
  get isBeside() {
    return getComputedStyle(byId("list")).display === "none";
  }

  /**
   * Show the list beside the picture, if there is room, with the events of a new view.
   * @param {View} view
   * @param {View} whole the whole timeline
   */
  show(view, whole) {
    const { isBeside } = this;
    if (isBeside !== this.wasBeside) byId("events").close();
    byId("events").open ||= isBeside; // `show()` would take the focus
    this.wasBeside = isBeside;
    if (!isBeside || view.events === this.events) return;
    this.fillRows(view, whole);
    this.search();
  }

  /**
   * @param {View} view
   * @param {View} whole
   */
  fillRows(view, whole) {
    this.events = view.events;
    this.rows = allEvents(view, whole).map((event) => ({
      event, text: eventText(event, this.info), when: momentText(event.time_s, this.info),
    }));
    byId("events-summary").textContent = summaryText(whole, this.info);
  }

  /**
   * @param {View} view
   * @param {View} whole
   */
  open(view, whole) {
    this.fillRows(view, whole);
    byId("find").value = "";
    this.search();
    if (!this.isBeside) byId("events").showModal();
    byId("events-title").focus();
  }

  close() {
    if (!this.isBeside) byId("events").close();
  }

  /**
   * Mark the event at which the input is, in the list beside the picture.
   * @param {TimelineEvent | null} event
   */
  mark(event) {
    if (event === this.marked || !this.wasBeside) return;
    this.marked = event;
    byId("events-list").querySelector("[aria-current]")?.removeAttribute("aria-current");
    const at = this.found.findIndex((row) => event && isSameEvent(row.event, event));
    if (at < 0) return;
    const block = /** @type {HTMLElement} */ (byId("events-list").children[Math.floor(at / BLOCK)]);
    this.fill(block, true);
    const item = block.children[at % BLOCK];
    item.setAttribute("aria-current", "true");
    item.scrollIntoView({ block: "nearest" });
  }

  /** Show the events that have the words, and whose kinds are shown. */
  search() {
    const words = plain(byId("find").value).split(/\s+/).filter(Boolean);
    this.found = this.rows.filter(({ event, text, when }) => {
      const all = plain(`${text} ${this.info.kinds[event.kind].name} ${when}`);
      return !this.hidden.has(event.kind) && words.every((word) => all.includes(word));
    });
    const { length } = this.found;
    byId("found").textContent = length === 0 && words.length > 0 ? NOTHING_FOUND : eventCount(length);
    byId("kinds").replaceChildren(...chipsOf(this.info, this.hidden, (kind) => {
      const at = [...byId("kinds").children].indexOf(/** @type {Element} */ (document.activeElement));
      this.toggle(kind);
      this.search();
      /** @type {HTMLElement | undefined} */ (byId("kinds").children[at])?.focus();
    }));
    this.observer.disconnect();
    const blocks = Array.from({ length: Math.ceil(length / BLOCK) }, (_, i) => {
      const block = made("ul", {});
      block.dataset.first = String(i * BLOCK);
      block.style.height = `${Math.min(BLOCK, length - i * BLOCK) * ROW_REM}rem`;
      return block;
    });
    byId("events-list").replaceChildren(...blocks);
    blocks.forEach((block) => this.observer.observe(block));
  }

  /**
   * Fill a block with its events, or empty it; it keeps its height.
   * @param {HTMLElement} block
   * @param {boolean} isNear
   */
  fill(block, isNear) {
    const isFilled = block.firstChild !== null;
    if (isNear === isFilled || block.contains(document.activeElement)) return;
    if (isNear) {
      const first = Number(block.dataset.first);
      block.replaceChildren(...this.found.slice(first, first + BLOCK).map((row, i) => this.item(row, first + i)));
      block.style.height = "";
    } else {
      block.style.height = `${block.getBoundingClientRect().height}px`;
      block.replaceChildren();
    }
  }

  /**
   * @param {Row} row
   * @param {number} index
   */
  item({ event, text, when }, index) {
    const item = made("li", {});
    item.setAttribute("aria-setsize", String(this.found.length));
    item.setAttribute("aria-posinset", String(index + 1));
    const { watch } = this;
    item.append(this.button("go", () => this.go(event),
      markIcon(markOf(event.kind, this.info.kinds[event.kind], event.side)), made("span", {}, text), " ",
      made("span", {}, when)));
    if (watch !== null) {
      const film = this.button("watch", () => watch(event), WATCH);
      film.setAttribute("aria-label", `${WATCH} ${when}, ${text}`);
      item.append(film);
    }
    return item;
  }

  /**
   * @param {string} name
   * @param {() => void} act
   * @param {(string | Node)[]} children
   */
  button(name, act, ...children) {
    return button(name, () => {
      this.close();
      act();
    }, ...children);
  }
}
