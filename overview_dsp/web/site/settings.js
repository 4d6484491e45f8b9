// What a person has chosen, kept in this browser.

const KEY = "overview";

const motor = "vibrate" in navigator && matchMedia("(pointer: coarse)").matches;

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

export function keepSettings(settings) {
  try {
    localStorage.setItem(KEY, JSON.stringify(settings));
  } catch {
    // a private window: they hold until it is closed
  }
}

/** Show settings in a form and tell of each change. */
export function bindSettings(form, settings, onchange) {
  for (const [name, value] of Object.entries(settings)) {
    const field = form.elements.namedItem(name);
    if (!field) continue;
    if (typeof value === "boolean") field.checked = value;
    else field.value = value;
  }
  form.addEventListener("input", ({ target }) => {
    const { name } = target;
    if (!(name in settings)) return;
    if (target.type === "checkbox") settings[name] = target.checked;
    else settings[name] = typeof settings[name] === "number" ? Number(target.value) : target.value;
    keepSettings(settings);
    onchange(name);
  });
}
