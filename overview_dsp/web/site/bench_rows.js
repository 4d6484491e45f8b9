// The rows of the bench, all from the parameter table: a slider, a choice or a switch each.

const STEPS = 400;

/** @import { Parameter } from "../types" */

/**
 * The value at `part` (0 to 1) of a parameter's range, and the part of a value.
 * @param {Parameter} known
 * @param {number} part
 */
export function valueAt({ low, high, scale }, part) {
  return scale === "log" ? low * (high / low) ** part : low + (high - low) * part;
}

/**
 * @param {Parameter} known
 * @param {number} value
 */
export function partOfValue({ low, high, scale }, value) {
  if (scale === "log") return Math.log(value / low) / Math.log(high / low);
  return (value - low) / (high - low);
}

/**
 * A number as a person reads it.
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
const words = (key) => key.split(".").at(-1).replace(UNIT, "").replaceAll("_", " ");

/**
 * A row for the value of `place[key]` that the table describes; `onchange()` follows each change.
 * Numbers are rounded to three digits, as they are shown and written.
 * @param {Parameter} known
 * @param {Record<string, any>} place
 * @param {string} key
 * @param {() => void} onchange
 */
export function rowOf(known, place, key, onchange) {
  const row = document.createElement("label");
  row.className = "parameter";
  const name = document.createElement("span");
  name.textContent = words(key);
  const doc = document.createElement("small");
  doc.textContent = known.doc;
  const control = known.choices.length > 0 ? choice(known, place, key, onchange)
    : slider(known, place, key, onchange);
  row.append(name, ...control, doc);
  return row;
}

/**
 * @param {Parameter} known
 * @param {Record<string, any>} place
 * @param {string} key
 * @param {() => void} onchange
 */
function choice({ choices, id }, place, key, onchange) {
  if (typeof choices[0] === "boolean") {
    const box = Object.assign(document.createElement("input"), { type: "checkbox", name: id });
    box.checked = place[key];
    box.addEventListener("input", () => {
      place[key] = box.checked;
      onchange();
    });
    return [box];
  }
  const select = Object.assign(document.createElement("select"), { name: id });
  select.append(...choices.map((one) => new Option(one.replaceAll("_", " "), one)));
  select.value = place[key];
  select.addEventListener("input", () => {
    place[key] = select.value;
    onchange();
  });
  return [select];
}

/**
 * @param {Parameter} known
 * @param {Record<string, any>} place
 * @param {string} key
 * @param {() => void} onchange
 */
function slider(known, place, key, onchange) {
  const told = document.createElement("output");
  const range = Object.assign(document.createElement("input"), {
    type: "range", name: known.id, min: "0", max: String(STEPS), step: "1",
  });
  const show = () => {
    told.textContent = valueText(place[key], known.unit);
    range.setAttribute("aria-valuetext", told.textContent);
  };
  range.value = String(Math.round(STEPS * partOfValue(known, place[key])));
  show();
  range.addEventListener("input", () => {
    const value = Number(valueAt(known, Number(range.value) / STEPS).toPrecision(3));
    place[key] = Math.min(Math.max(value, known.low), known.high);
    show();
    onchange();
  });
  return [told, range];
}
