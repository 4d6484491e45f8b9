// Questionnaires: forms from study.json and their values.

import { make, paragraphs } from "./make.js";

/** Return a form's element and `value()`, which is null and reports by `say` while an answer is missing. */
export async function formOf(described, { say, file }) {
  if (described.file) return ownForm(await (await file(described.file)).text());
  if (described.text !== undefined) return consentForm(described, say);
  const items = described.items.map(itemOf);
  return {
    element: make("div", { class: "items" }, ...items.map(({ element }) => element)),
    value() {
      const missing = items.find(({ value }) => value() === undefined);
      if (missing) {
        say(`Not answered yet: ${missing.question}`);
        missing.focus();
        return null;
      }
      return Object.fromEntries(items.map(({ id, value }) => [id, value()]));
    },
  };
}

function itemOf(item) {
  if (item.lines) return textItem(item);
  if (item.choices) return choiceItem(item);
  return scaleItem(item);
}

function textItem({ id, question, lines }) {
  const area = make("textarea", { id: `item-${id}`, rows: lines });
  const element = make("div", { class: "item" },
    make("label", { for: `item-${id}`, text: question }), area);
  return { id, question, element, value: () => area.value, focus: () => area.focus() };
}

function choiceItem({ id, question, choices }) {
  const radios = choices.map((one) => make("input", { type: "radio", name: id, value: one }));
  const element = make("fieldset", { class: "item" }, make("legend", { text: question }),
    ...radios.map((radio, i) => make("label", {}, radio, make("span", { text: choices[i] }))));
  const value = () => radios.find(({ checked }) => checked)?.value;
  return { id, question, element, value, focus: () => radios[0].focus() };
}

/** Return a scale; it needs a change, or Space or Enter to accept the current value. */
function scaleItem({ id, question, low, high, min, max, step }) {
  let touched = false;
  const scale = make("input", {
    type: "range", id: `item-${id}`, min, max, step, value: (min + max) / 2,
    "aria-describedby": `ends-${id}`, "aria-valuetext": "not answered", class: "untouched",
  });
  const touch = () => {
    touched = true;
    scale.classList.remove("untouched");
    scale.removeAttribute("aria-valuetext");
  };
  scale.addEventListener("input", touch);
  scale.addEventListener("pointerdown", touch);
  scale.addEventListener("keydown", (event) => {
    if (event.key !== " " && event.key !== "Enter") return;
    event.preventDefault();
    touch();
  });
  const element = make("div", { class: "item scale" },
    make("label", { for: `item-${id}`, text: question }), scale,
    make("div", { class: "ends", id: `ends-${id}` },
      make("span", { text: low }), make("span", { text: high })));
  const value = () => (touched ? Number(scale.value) : undefined);
  return { id, question, element, value, focus: () => scale.focus() };
}

function consentForm({ version, text }, say) {
  const box = make("input", { type: "checkbox", id: "agreed" });
  const element = make("div", { class: "items" }, ...paragraphs(text),
    make("label", { for: "agreed" }, box, make("span", { text: "I have read this and agree." })));
  const value = () => {
    if (box.checked) return { version, agreed: true };
    say("To take part, tick the box.");
    box.focus();
    return null;
  };
  return { element, value, consent: true };
}

/** Return a form from an HTML file with named fields. */
function ownForm(html) {
  const form = make("form", { class: "items" });
  form.innerHTML = html;
  form.addEventListener("submit", (event) => event.preventDefault());
  const value = () => (form.reportValidity() ? valuesOf(form) : null);
  return { element: form, value };
}

/** Return field values by name: numbers for number fields, lists for checkboxes. */
export function valuesOf(form) {
  const found = {};
  for (const field of form.elements) {
    if (!field.name || field.disabled) continue;
    const ticks = field.type === "checkbox";
    if (ticks) found[field.name] ??= [];
    if ((ticks || field.type === "radio") && !field.checked) continue;
    const number = ["number", "range"].includes(field.type) && field.value !== "";
    const value = number ? Number(field.value) : field.value;
    if (ticks) found[field.name].push(value);
    else found[field.name] = value;
  }
  return found;
}
