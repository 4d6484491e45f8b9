// Rows of the preset editor: one slider, choice or switch per parameter.

import { made } from "./dom.js";

const STEPS = 400;

/** @import { Parameter } from "../types" */

/**
 * Return the value at `part` (0 to 1) of a parameter's range.
 * @param {Parameter} parameter
 * @param {number} part
 */
export function valueOfPart({ low, high, scale }, part) {
  return scale === "log" ? low * (high / low) ** part : low + (high - low) * part;
}

/**
 * @param {Parameter} parameter
 * @param {number} value
 */
export function partOfValue({ low, high, scale }, value) {
  if (scale === "log") return Math.log(value / low) / Math.log(high / low);
  return (value - low) / (high - low);
}

/**
 * Return a number with its unit, to three digits.
 * @param {number} value
 * @param {string} unit
 */
export function valueText(value, unit) {
  const number = Number(value.toPrecision(3));
  const size = Math.abs(number);
  const text = size !== 0 && (size < 1e-4 || size >= 1e5) ? number.toExponential() : String(number);
  return unit ? `${text} ${unit}` : text;
}

const UNIT = /_(ms|hz|db|deg|percent|mnm)$/;

/** @param {string} key */
export const labelOf = (key) => key.slice(key.lastIndexOf(".") + 1).replace(UNIT, "").replaceAll("_", " ");

/**
 * Return a row for `owner[key]`; `onchange()` is called after each change. Numbers are rounded to
 * three digits, as in the text and in the preset file.
 * @param {Parameter} parameter
 * @param {Record<string, any>} owner
 * @param {string} key
 * @param {() => void} onchange
 */
export function rowOf(parameter, owner, key, onchange) {
  const control = parameter.choices.length > 0 ? choice(parameter, owner, key, onchange)
    : slider(parameter, owner, key, onchange);
  return made("label", { className: "parameter" }, made("span", {}, labelOf(key)), ...control,
    made("small", {}, parameter.doc));
}

/**
 * @param {Parameter} parameter
 * @param {Record<string, any>} owner
 * @param {string} key
 * @param {() => void} onchange
 */
function choice({ choices, id }, owner, key, onchange) {
  if (typeof choices[0] === "boolean") {
    const box = made("input", { type: "checkbox", name: id });
    box.checked = owner[key];
    box.addEventListener("input", () => {
      owner[key] = box.checked;
      onchange();
    });
    return [box];
  }
  const select = made("select", { name: id });
  select.append(...choices.map((one) => new Option(one.replaceAll("_", " "), one)));
  select.value = owner[key];
  select.addEventListener("input", () => {
    owner[key] = select.value;
    onchange();
  });
  return [select];
}

/**
 * @param {Parameter} parameter
 * @param {Record<string, any>} owner
 * @param {string} key
 * @param {() => void} onchange
 */
function slider(parameter, owner, key, onchange) {
  const output = made("output", {});
  const range = made("input", {
    type: "range", name: parameter.id, min: "0", max: String(STEPS), step: "1",
  });
  const show = () => {
    output.textContent = valueText(owner[key], parameter.unit);
    range.setAttribute("aria-valuetext", output.textContent);
  };
  range.value = String(Math.round(STEPS * partOfValue(parameter, owner[key])));
  show();
  range.addEventListener("input", () => {
    const value = Number(valueOfPart(parameter, Number(range.value) / STEPS).toPrecision(3));
    owner[key] = Math.min(Math.max(value, parameter.low), parameter.high);
    show();
    onchange();
  });
  return [output, range];
}
