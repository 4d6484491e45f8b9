// Functions that create elements.

/**
 * Create an element with attributes (`text`, listeners in `on`) and children.
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

/** Return one paragraph per block of text. */
export const paragraphs = (text) =>
  text.split(/\n\s*\n/).filter((one) => one.trim()).map((one) => make("p", { text: one.trim() }));

/** Return a button that ignores the second click of a double click. */
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

/** Add a button and wait until it is pressed. */
export const pressed = (text, attributes, parent) =>
  new Promise((resolve) => {
    parent.append(button(text, resolve, attributes));
  });

/** Return an action's result; on failure show the error and a button to try again. */
export async function retryUntilDone(act, parent, fault, label = "Try again") {
  for (;;) {
    try {
      return await act();
    } catch (error) {
      fault(error.message);
      const again = make("p", { class: "again" });
      parent.append(again);
      await pressed(label, {}, again);
      again.remove();
      fault("");
    }
  }
}
