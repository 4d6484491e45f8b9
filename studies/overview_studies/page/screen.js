// jsPsych plugin for screens without trials: instructions, breaks, consent and questionnaires.

import { showExample } from "./example.js";
import { formOf } from "./forms.js";
import { button, retryUntilDone, make, paragraphs, pressed } from "./make.js";
import { VERSION } from "./trial.js";

/** Return the plugin of one session; `kit` is that of `trialPlugin`. */
export function screenPlugin(kit) {
  const { ParameterType } = /** @type {any} */ (globalThis).jsPsychModule;
  return class OverviewScreen {
    static info = {
      name: "overview-screen",
      version: VERSION,
      parameters: { step: { type: ParameterType.OBJECT, default: undefined } },
      data: { response: { type: ParameterType.COMPLEX } },
    };

    async trial(display, { step }, onLoad) {
      kit.progress();
      const shown = SCREENS[step.type] ?? showText;
      const response = await shown(kit, display, step, onLoad);
      return { trial_id: step.id, response };
    }
  };
}

/** Show text until a button is pressed. */
async function showText(kit, display, step, onLoad) {
  const heading = make("h1", { text: headingOf(step), tabindex: -1 });
  display.replaceChildren(heading, ...linesOf(kit.study, step).flatMap(paragraphs));
  const go = pressed(step.type === "break" ? "Continue" : "Start", { class: "done" }, display);
  heading.focus();
  window.scrollTo(0, 0);
  onLoad();
  await go;
  kit.felt.start().catch((error) => kit.fault(error.message));
  return null;
}

const headingOf = ({ type, again }) => {
  if (again) return "Once more";
  return type === "break" ? "A break" : "What to do";
};

function linesOf({ text }, { type, again, text: own, practice }) {
  if (again) return ["Too few answers were correct. Please practise once more."];
  if (type === "break") return ["Rest as long as you like.", own].filter(Boolean);
  return [text.instructions, own, practice ? "Practice trials come first." : ""].filter(Boolean);
}

/** Show a form until it is complete; return its values. */
async function showForm(kit, display, step, onLoad) {
  const { study, fault } = kit;
  display.replaceChildren();
  const form = await retryUntilDone(() => formOf(study.forms[step.form], kit), display, fault);
  const heading = make("h1", { text: form.consent ? "Consent" : titleOf(step), tabindex: -1 });
  const started = new Date();
  const begun = performance.now();
  display.replaceChildren(heading, form.element);
  heading.focus();
  window.scrollTo(0, 0);
  onLoad();
  const response = await filled(kit, display, form);
  const row = {
    response, rt_ms: performance.now() - begun, started_utc: started.toISOString(), version: VERSION,
  };
  await retryUntilDone(() => kit.answers.add(step.id, row), display, fault, "Store it again");
  return response;
}

function filled(kit, display, form) {
  return new Promise((resolve) => {
    let over = false;
    const take = () => {
      const value = form.value();
      if (value === null || over) return;
      over = true;
      resolve(value);
    };
    const done = button(form.consent ? "Take part" : "Next", take, { class: "done" });
    display.append(done);
    if (form.consent) display.append(button("I do not agree", () => kit.leave()));
  });
}

const SCREENS = { form: showForm, example: showExample };

const TITLES = { tlx: "How was it?", comments: "Comments", about: "About you" };

function titleOf({ form }) {
  return TITLES[form] ?? form.replaceAll(/[-_]/g, " ").replace(/^./, (first) => first.toUpperCase());
}
