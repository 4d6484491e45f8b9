// Keys of the slider and their list in the help.

const STEP = 0.01;
const PAGE = 0.1;

/** @import { ViewState } from "./view_state.js" */
/** @import { Navigation } from "./navigation.js" */

export const HELP = [
  ["Arrows, Page keys", "move, in small or large steps"],
  ["[ and ]", "previous and next event"],
  ["Home, End", "first, last"],
  ["X, N", "highest, lowest"],
  ["Space", "tap: touch and release"],
  ["Escape", "release"],
  ["P", "play or pause"],
  ["+ and \u2212", "zoom"],
  ["E", "list of events"],
  ["V", "watch the film, if there is one"],
  ["H", "this help"],
];

/**
 * `open(name)` opens events, run, help or film; `onfirst()` is called before each key.
 * @param {HTMLElement} element
 * @param {{ navigation: Navigation, viewState: ViewState, open: (name: string) => void }} parts
 * @param {() => void} onfirst
 */
export function listenToKeys(element, { navigation, viewState, open }, onfirst) {
  /** @type {Record<string, (event: KeyboardEvent) => unknown>} */
  const keys = {
    ArrowRight: ({ shiftKey }) => navigation.move(shiftKey ? PAGE : STEP),
    ArrowUp: ({ shiftKey }) => navigation.move(shiftKey ? PAGE : STEP),
    ArrowLeft: ({ shiftKey }) => navigation.move(shiftKey ? -PAGE : -STEP),
    ArrowDown: ({ shiftKey }) => navigation.move(shiftKey ? -PAGE : -STEP),
    PageUp: () => navigation.move(PAGE),
    PageDown: () => navigation.move(-PAGE),
    Home: () => navigation.first(),
    End: () => navigation.last(),
    x: () => navigation.highest(),
    n: () => navigation.lowest(),
    "[": () => navigation.toEvent(-1),
    "]": () => navigation.toEvent(1),
    " ": ({ repeat }) => repeat || navigation.tap(),
    Escape: () => navigation.release(),
    "+": () => viewState.zoom(1),
    "=": () => viewState.zoom(1),
    "-": () => viewState.zoom(-1),
    e: () => open("events"),
    p: () => open("run"),
    h: () => open("help"),
    "?": () => open("help"),
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
