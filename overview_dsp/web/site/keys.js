// Keys on the slider: all that a finger can do.

const STEP = 0.01;
const PAGE = 0.1;

/** `walk`: a Walk; `shown`: a Shown; `play()` opens the film; `onfirst()` comes before each. */
export function listenToKeys(element, { walk, shown, play }, onfirst) {
  const keys = {
    ArrowRight: ({ shiftKey }) => walk.move(shiftKey ? PAGE : STEP),
    ArrowUp: ({ shiftKey }) => walk.move(shiftKey ? PAGE : STEP),
    ArrowLeft: ({ shiftKey }) => walk.move(shiftKey ? -PAGE : -STEP),
    ArrowDown: ({ shiftKey }) => walk.move(shiftKey ? -PAGE : -STEP),
    PageUp: () => walk.move(PAGE),
    PageDown: () => walk.move(-PAGE),
    Home: () => walk.to(0),
    End: () => walk.to(1),
    "[": () => walk.event(-1),
    "]": () => walk.event(1),
    " ": ({ repeat }) => repeat || walk.tap(),
    Escape: () => walk.letGo(),
    "+": () => shown.zoom(1),
    "=": () => shown.zoom(1),
    "-": () => shown.zoom(-1),
    v: () => play(),
  };
  element.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || !Object.hasOwn(keys, event.key)) return;
    event.preventDefault();
    onfirst();
    keys[event.key](event);
  });
}
