// Answers by one press: each choice has a button and a digit key.

import { button, make } from "./make.js";

const DIGITS = 9;

/** `choices`: [value, label] pairs; `context.answer(value)` records the answer. */
export function choose(choices, { answer, label }) {
  const buttons = choices.map(([value, text], i) => {
    const one = button(text, () => answer(value), {
      disabled: true, class: "choice", "aria-keyshortcuts": i < DIGITS ? i + 1 : null,
    });
    if (i < DIGITS) one.prepend(make("small", { text: String(i + 1), "aria-hidden": "true" }));
    return one;
  });
  return {
    element: make("div", { class: "choices", role: "group", "aria-label": label }, ...buttons),
    enable() {
      for (const one of buttons) one.disabled = false;
    },
    /** Handle a digit key; return whether it selects a choice. */
    key(name) {
      const at = Number(name) - 1;
      if (!/^[1-9]$/.test(name) || at >= choices.length) return false;
      answer(choices[at][0]);
      return true;
    },
  };
}

export const identify = (context) =>
  choose(context.study.task.choices.map((one) => [one, context.study.task.words[one] ?? one]), context);

export const compare = (context) => choose([[0, "The first"], [1, "The second"]], context);

export const detectYesNo = (context) => {
  const { words } = context.study.task;
  return choose([[1, words[1] ?? "I felt it"], [0, words[0] ?? "I felt nothing"]], context);
};
