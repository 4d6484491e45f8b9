// Answers by a number: a count, a position or a level.

import { button, make } from "./make.js";

const MOST = 999;

/** Return controls with a button that records `value()`. */
function confirmed(label, value, { answer }, ...parts) {
  const done = button(label, () => {
    const response = value();
    if (response !== undefined) answer(response);
  }, { disabled: true, class: "done" });
  return {
    element: make("div", { class: "measure" }, ...parts, done),
    enable() {
      done.disabled = false;
      for (const part of parts) {
        if (part.matches?.("button")) part.disabled = false;
      }
    },
  };
}

export function count(context) {
  const number = make("input", {
    type: "number", id: "how-many", min: 0, max: MOST, step: 1, inputmode: "numeric", value: "",
  });
  const by = (step) => () => {
    number.value = String(Math.min(Math.max((Number(number.value) || 0) + step, 0), MOST));
  };
  const row = make("div", { class: "stepper" },
    button("\u2212", by(-1), { "aria-label": "One less" }), number,
    button("+", by(1), { "aria-label": "One more" }));
  const label = make("label", { for: "how-many", text: "How many" });
  const value = () => {
    const whole = number.value.trim() !== "" && number.checkValidity();
    if (whole) return Number(number.value);
    context.say("Enter a whole number.");
    number.focus();
    return undefined;
  };
  const made = confirmed("Answer", value, context, label, row);
  number.addEventListener("keydown", ({ key, repeat }) => {
    if (key === "Enter" && !repeat) made.element.querySelector(".done").click();
  });
  return made;
}

/** Return controls for a position: the last input position, or a scale for played stimuli. */
export function locate(context) {
  const { stage, answer } = context;
  const none = button("Nothing there", () => answer(null), { disabled: true });
  if (stage.free) return confirmed("It is here", () => stage.pad.position, context, none);
  const scale = make("input", { type: "range", id: "where", min: 0, max: 100, step: 0.5, value: 50 });
  let moved = false;
  const label = make("label", { for: "where", text: "Where, from start to end" });
  scale.addEventListener("input", () => {
    moved = true;
  });
  const value = () => {
    if (moved) return Number(scale.value) / 100;
    context.say("Move the scale to answer.");
    scale.focus();
    return undefined;
  };
  return confirmed("It is here", value, context, label, scale, none);
}

/** Return controls that adjust the second stimulus; `trial.adjustable` has one stimulus per level. */
export function adjust(context) {
  const { trial: { levels, adjustable, stimuli }, stage } = context;
  const last = levels.length - 1;
  const scale = make("input", { type: "range", id: "level", min: 0, max: last, step: 1 });
  let at = 0;
  const show = (to) => {
    at = Math.min(Math.max(to, 0), last);
    scale.value = String(at);
    scale.setAttribute("aria-valuetext", `step ${at + 1} of ${last + 1}`);
  };
  const go = (to) => {
    show(to);
    stage.replace(adjustable[at]).catch((error) => context.fault(error.message));
  };
  show(adjustable.indexOf(stimuli[1]));
  scale.addEventListener("input", () => go(Number(scale.value)));
  const row = make("div", { class: "stepper" },
    button("Less", () => go(at - 1)), scale, button("More", () => go(at + 1)));
  const label = make("label", { for: "level", text: "The second: less or more" });
  return confirmed("They are equal", () => levels[at], context, label, row);
}
