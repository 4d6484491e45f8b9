// What a person has chosen, kept in this browser.

/** @import { Settings } from "../types" */

const KEY = "overview";

const motor = "vibrate" in navigator && matchMedia("(pointer: coarse)").matches;

/** @type {Settings} */
const FIRST = {
  felt: motor ? "motor" : "ears",
  clicks: true,
  vibration: true,
  speech: false,
  volume: 0, // dB
  sweep: 10, // s that Play takes
  loop: false,
  name: navigator.userAgent.match(/iPhone|iPad|Android|Windows|Macintosh|Linux/)?.[0] ?? "",
  contrast: matchMedia("(prefers-contrast: more)").matches,
  still: matchMedia("(prefers-reduced-motion: reduce)").matches,
  start: 0, // roll at the timeline's start, rad
};

/** @returns {Settings} */
export function loadSettings() {
  try {
    const kept = JSON.parse(localStorage.getItem(KEY) ?? "{}");
    const known = Object.entries(FIRST).map(([name, first]) => [
      name,
      typeof kept[name] === typeof first ? kept[name] : first,
    ]);
    return Object.fromEntries(known);
  } catch {
    return { ...FIRST }; // no storage here, or not ours
  }
}

/** @param {Settings} settings */
export function keepSettings(settings) {
  try {
    localStorage.setItem(KEY, JSON.stringify(settings));
  } catch {
    // a private window: they hold until it is closed
  }
}

/**
 * Show settings in a form and tell of each change.
 * @param {HTMLFormElement} form
 * @param {Settings} settings
 * @param {(name: string) => void} onchange
 */
export function bindSettings(form, settings, onchange) {
  for (const [name, value] of Object.entries(settings)) {
    const field = /** @type {any} */ (form.elements.namedItem(name));
    if (!field) continue;
    if (typeof value === "boolean") field.checked = value;
    else field.value = value;
  }
  form.addEventListener("input", (event) => {
    const target = /** @type {HTMLInputElement} */ (event.target);
    const { name } = target;
    if (!(name in settings)) return;
    const chosen = /** @type {Record<string, any>} */ (settings);
    if (target.type === "checkbox") chosen[name] = target.checked;
    else chosen[name] = typeof chosen[name] === "number" ? Number(target.value) : target.value;
    keepSettings(settings);
    onchange(name);
  });
}
