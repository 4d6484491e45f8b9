// Settings of the user, stored in this browser.

import { byId } from "./dom.js";
import { NO_VIBRATION } from "./page_words.js";

/** @import { Settings } from "../types" */

const KEY = "overview";

const motor = "vibrate" in navigator && matchMedia("(pointer: coarse)").matches;

/** @type {Settings} */
const DEFAULTS = {
  output: motor ? "motor" : "ears",
  clicks: true,
  vibration: true,
  speech: false,
  volume: 0, // dB
  sweep: 10, // duration of Play, s
  loop: false,
  steps: "events", // stops of the buttons Previous and Next
  name: navigator.userAgent.match(/iPhone|iPad|Android|Windows|Macintosh|Linux/)?.[0] ?? "",
  contrast: matchMedia("(prefers-contrast: more)").matches,
  circular: false, // a dial to turn
  still: matchMedia("(prefers-reduced-motion: reduce)").matches,
  start: 0, // roll at the timeline's start, rad
};

/** @returns {Settings} */
export function loadSettings() {
  try {
    const stored = JSON.parse(localStorage.getItem(KEY) ?? "{}");
    const entries = Object.entries(DEFAULTS).map(([name, initial]) => [
      name,
      typeof stored[name] === typeof initial ? stored[name] : initial,
    ]);
    return Object.fromEntries(entries);
  } catch {
    return { ...DEFAULTS }; // no storage, or invalid content
  }
}

/** @param {Settings} settings */
export function saveSettings(settings) {
  try {
    localStorage.setItem(KEY, JSON.stringify(settings));
  } catch {
    // a private window: the settings last until it is closed
  }
}

/**
 * Show the settings in a form and report each change.
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
  if (!("vibrate" in navigator)) {
    byId("motor").textContent = NO_VIBRATION;
    /** @type {any} */ (form.elements.namedItem("output"))[1].disabled = true;
  }
  form.addEventListener("input", (event) => {
    const target = /** @type {HTMLInputElement} */ (event.target);
    const { name } = target;
    if (!(name in settings)) return;
    const chosen = /** @type {Record<string, any>} */ (settings);
    if (target.type === "checkbox") chosen[name] = target.checked;
    else chosen[name] = typeof chosen[name] === "number" ? Number(target.value) : target.value;
    saveSettings(settings);
    onchange(name);
  });
}
