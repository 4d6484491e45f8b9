// Keys on the slider: all that a finger can do.

const STEP = 0.01;
const PAGE = 0.1;

/** `act` has the methods move, to, event, tap, letGo, zoom, play; `onfirst()` comes before each. */
export function listenToKeys(element, act, onfirst) {
  const keys = {
    ArrowRight: ({ shiftKey }) => act.move(shiftKey ? PAGE : STEP),
    ArrowUp: ({ shiftKey }) => act.move(shiftKey ? PAGE : STEP),
    ArrowLeft: ({ shiftKey }) => act.move(shiftKey ? -PAGE : -STEP),
    ArrowDown: ({ shiftKey }) => act.move(shiftKey ? -PAGE : -STEP),
    PageUp: () => act.move(PAGE),
    PageDown: () => act.move(-PAGE),
    Home: () => act.to(0),
    End: () => act.to(1),
    "[": () => act.event(-1),
    "]": () => act.event(1),
    " ": ({ repeat }) => repeat || act.tap(),
    Escape: () => act.letGo(),
    "+": () => act.zoom(1),
    "=": () => act.zoom(1),
    "-": () => act.zoom(-1),
    v: () => act.play(),
  };
  element.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || !Object.hasOwn(keys, event.key)) return;
    event.preventDefault();
    onfirst();
    keys[event.key](event);
  });
}
