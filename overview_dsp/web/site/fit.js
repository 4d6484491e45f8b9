// The text above the picture: the first of some sizes at which the data's longest texts fit.

import { byId, contextOf } from "./dom.js";
import { gapText, momentText, shortEvent } from "./descriptions.js";
import { markIcon } from "./legend.js";
import { textSize } from "./picture.js";
import { numberText } from "./values.js";
import { NO_DATA } from "./words.js";

/** @import { Info, View } from "../types" */

const STEPS = 6; // sizes of the style sheet: `data-fit` names a step and those before it
const LEAST = 150; // minimum height (px) of the picture
const LABELLED = [90, 40]; // and with its labels, for text of 0 and of each 16 px
const SHARE = 0.45; // of the window's height that the picture has before the title gives way
const MOMENTS = 60; // moments that are measured
const CANDIDATES = 6; // events that are laid out

/** @param {string[]} texts */
const longest = (texts) => widest(texts)[0];

/**
 * Return some of the widest of many texts.
 * @param {string[]} texts
 */
function widest(texts) {
  const c = contextOf(document.createElement("canvas"));
  c.font = "16px system-ui";
  const longer = [...new Set(texts)].sort((a, b) => b.length - a.length).slice(0, MOMENTS);
  const widths = longer.map((text) => /** @type {[string, number]} */ ([text, c.measureText(text).width]));
  widths.sort(([, a], [, b]) => b - a);
  return widths.length > 0 ? widths.slice(0, CANDIDATES).map(([text]) => text) : [""];
}

/** The longest texts of all views so far. @type {ReturnType<typeof longestTexts>} */
let longestSoFar = { clock: "", numbers: [""], unit: "", events: [], isZoomed: false };

/**
 * Return the longest texts of a view and of those before: moment, value and events.
 * @param {View} view
 * @param {Info} info
 * @returns {{ clock: string, numbers: string[], unit: string, events: string[], isZoomed: boolean }}
 */
function longestTexts(view, info) {
  const values = view.points?.value ?? [];
  const ends = values.length > 0 ? [Math.min, Math.max].map((most) => values.reduce((a, b) => most(a, b))) : [];
  const { start_s, end_s } = view;
  const moments = Array.from({ length: MOMENTS }, (_, i) =>
    momentText(start_s + ((end_s - start_s) * i) / (MOMENTS - 1), info));
  return {
    clock: longest([longestSoFar.clock, ...moments]),
    numbers: info.series
      ? [longest([longestSoFar.numbers[0], ...ends.map((one) => numberText(one, info))]), NO_DATA] : ["00\u201300"],
    unit: info.series?.unit ?? "",
    events: widest([
      ...longestSoFar.events, ...view.events.map((event) => shortEvent(event, info)),
      ...view.gaps.map(([from, to]) => gapText(view, (from + to) / 2, info)),
    ]),
    isZoomed: longestSoFar.isZoomed || view.zoom > 0, // other buttons are below the picture
  };
}

/**
 * Set the size of the texts (`data-fit`) and the fixed height of the text above the picture, if the window
 * has another size or the view has longer texts than those before. Return whether it was set.
 * @param {View} view
 * @param {Info} info
 */
export function fit(view, info, isResized = true) {
  if (isResized) longestSoFar.isZoomed = false;
  const found = longestTexts(view, info);
  if (!isResized && JSON.stringify(found) === JSON.stringify(longestSoFar)) return false;
  longestSoFar = found;
  const root = document.documentElement;
  const box = byId("moment");
  const names = /** @type {const} */ (["clock", "number", "unit", "event"]);
  box.style.contain = "";
  const before = names.map((name) => [...byId(name).childNodes]);
  byId("clock").textContent = found.clock;
  byId("unit").textContent = found.unit;
  for (let step = 0; step < STEPS; step += 1) {
    root.dataset.fit = "012345".slice(0, step + 1);
    root.style.removeProperty("--reading");
    let height = 0;
    let isCut = false;
    for (const [number, event] of found.numbers.flatMap((one) => found.events.map((text) => [one, text]))) {
      byId("number").textContent = number;
      byId("event").replaceChildren(event && markIcon({ shape: "circle", colour: "ink", isRing: false }), event);
      height = Math.max(height, Math.ceil(box.getBoundingClientRect().height));
      isCut ||= [box, ...names.map(byId)].some((one) => one.clientWidth > 0 && one.scrollWidth > one.clientWidth + 1);
    }
    root.style.setProperty("--reading", `${height}px`);
    const least = Math.max(LEAST, LABELLED[0] + LABELLED[1] * textSize(), step < 2 ? SHARE * window.innerHeight : 0);
    const picture = byId("stage").getBoundingClientRect().height;
    if (!isCut && picture >= least && root.scrollHeight <= window.innerHeight) break;
  }
  names.forEach((name, i) => byId(name).replaceChildren(...before[i]));
  box.style.contain = "strict"; // a new text lays out nothing else
  return true;
}
