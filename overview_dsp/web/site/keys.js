// Keys of the slider and their list in the help.

const STEP = 0.01;
const PAGE = 0.1;

/** @import { Navigation } from "./navigation.js" */

/**
 * `open(name)` opens events, help or film, or plays (run); `onfirst()` is called before each key.
 * @param {HTMLElement} element
 * @param {{ navigation: Navigation, open: (name: string) => void }} parts
 * @param {() => void} onfirst
 */
export function listenToKeys(element, { navigation, open }, onfirst) {
  /** @type {(direction: number) => (event: KeyboardEvent) => unknown} */
  const step = (direction) => ({ shiftKey }) =>
    (shiftKey ? navigation.move(direction * STEP) : navigation.step(direction));
  /** @param {KeyboardEvent} event */
  const tap = ({ repeat }) => repeat || navigation.tap();
  const help = () => open("help");
  /** @type {Record<string, (event: KeyboardEvent) => unknown>} */
  const keys = {
    ArrowRight: step(1),
    ArrowUp: step(1),
    ArrowLeft: step(-1),
    ArrowDown: step(-1),
    PageUp: () => navigation.move(PAGE),
    PageDown: () => navigation.move(-PAGE),
    Home: () => navigation.toFirst(),
    End: () => navigation.toLast(),
    x: () => navigation.toHighest(),
    n: () => navigation.toLowest(),
    "[": () => navigation.toEvent(-1),
    "]": () => navigation.toEvent(1),
    ",": () => navigation.toValue(-1),
    ".": () => navigation.toValue(1),
    " ": tap,
    t: tap,
    Escape: () => navigation.release(),
    "+": () => navigation.zoom(1),
    "=": () => navigation.zoom(1),
    "-": () => navigation.zoom(-1),
    e: () => open("events"),
    p: () => open("run"),
    h: help,
    "?": help,
    v: () => open("film"),
  };
  element.addEventListener("keydown", (event) => {
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    if (event.ctrlKey || event.altKey || event.metaKey || !Object.hasOwn(keys, key)) return;
    event.preventDefault();
    onfirst();
    keys[key](event);
  });
}
