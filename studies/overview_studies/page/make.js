// Elements from a line each.

/**
 * An element with attributes (`text` is its text, `on` its listeners by name) and children.
 * @param {string} name
 * @param {any} given
 * @param {...any} children
 * @returns {any}
 */
export function make(name, { text = "", on = {}, ...attributes } = {}, ...children) {
  const element = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (value === true) element.setAttribute(key, "");
    else if (value !== false && value !== null) element.setAttribute(key, String(value));
  }
  if (text) element.textContent = text;
  for (const [event, act] of Object.entries(on)) element.addEventListener(event, act);
  element.append(...children.filter((child) => child !== null));
  return element;
}

/** A paragraph for each block of lines. */
export const paragraphs = (text) =>
  text.split(/\n\s*\n/).filter((one) => one.trim()).map((one) => make("p", { text: one.trim() }));

/** A button; the second click of a double click is none. */
export function button(text, act, attributes = {}) {
  const pressed = (event) => {
    if (event.detail < 2) act(event);
  };
  return make("button", { type: "button", text, on: { click: pressed }, ...attributes });
}

export const pause = (ms) =>
  new Promise((resolve) => {
    setTimeout(resolve, ms);
  });

/** When it is pressed. */
export const pressed = (text, attributes, place) =>
  new Promise((resolve) => {
    place.append(button(text, resolve, attributes));
  });

/** What an action gives; where it fails the person is told by `fault` and may try again. */
export async function insisted(act, place, fault, words = "Try again") {
  for (;;) {
    try {
      return await act();
    } catch (error) {
      fault(error.message);
      const again = make("p", { class: "again" });
      place.append(again);
      await pressed(words, {}, again);
      again.remove();
      fault("");
    }
  }
}
