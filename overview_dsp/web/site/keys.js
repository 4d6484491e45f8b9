// Keys on the slider: all that a finger can do, and a table of them for a person.

const STEP = 0.01;
const PAGE = 0.1;

/** @import { Shown } from "./shown.js" */
/** @import { Walk } from "./walk.js" */

export const HELP = [
  ["Arrows, Page keys", "move, move further"],
  ["[ and ]", "previous and next event"],
  ["Home, End", "first, last"],
  ["X, N", "highest, lowest"],
  ["Space", "tap: to here, and let go"],
  ["Escape", "let go"],
  ["P", "play it by itself, or pause"],
  ["+ and \u2212", "zoom"],
  ["E", "list of events"],
  ["V", "watch the film, where there is one"],
  ["H", "this help"],
];

/**
 * `walk`: a Walk; `shown`: a Shown; `open(name)`: events, run, help or film; `onfirst()` comes before
 * each.
 * @param {HTMLElement} element
 * @param {{ walk: Walk, shown: Shown, open: (name: string) => void }} parts
 * @param {() => void} onfirst
 */
export function listenToKeys(element, { walk, shown, open }, onfirst) {
  /** @type {Record<string, (event: KeyboardEvent) => unknown>} */
  const keys = {
    ArrowRight: ({ shiftKey }) => walk.move(shiftKey ? PAGE : STEP),
    ArrowUp: ({ shiftKey }) => walk.move(shiftKey ? PAGE : STEP),
    ArrowLeft: ({ shiftKey }) => walk.move(shiftKey ? -PAGE : -STEP),
    ArrowDown: ({ shiftKey }) => walk.move(shiftKey ? -PAGE : -STEP),
    PageUp: () => walk.move(PAGE),
    PageDown: () => walk.move(-PAGE),
    Home: () => walk.first(),
    End: () => walk.last(),
    x: () => walk.highest(),
    n: () => walk.lowest(),
    "[": () => walk.event(-1),
    "]": () => walk.event(1),
    " ": ({ repeat }) => repeat || walk.tap(),
    Escape: () => walk.letGo(),
    "+": () => shown.zoom(1),
    "=": () => shown.zoom(1),
    "-": () => shown.zoom(-1),
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
