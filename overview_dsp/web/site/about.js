// Description of the data and legend of the marks, in the settings.

import { contextOf } from "./dom.js";
import { drawMark } from "./marks.js";
import { coloursOf } from "./picture.js";

/** @import { Colours, Info, Kind, View } from "../types" */

const SIZE = 26; // CSS pixels of a mark
const STRETCHED = "Where the axis is bold, time is stretched to separate close events";

/**
 * Fill `about` with sentences on the data and each of `lists` with one item per event kind.
 * @param {HTMLElement} about
 * @param {Element[]} lists
 * @param {Info} info
 * @param {View} view
 */
export function showAbout(about, lists, info, view) {
  const axis = view.angle_map ? STRETCHED : "";
  about.textContent = [info.provenance, ...info.notes, axis].filter(Boolean).join(". ");
  const colours = coloursOf(document.documentElement);
  // ticks of time need no legend
  const kinds = Object.values(info.kinds).filter((kind) => kind.count > 0 || kind.shape !== "bar");
  for (const list of lists) list.replaceChildren(...kinds.map((kind) => itemOf(kind, colours)));
}

/**
 * @param {Kind} kind
 * @param {Colours} colours
 */
function itemOf({ name, shape, colour, count }, colours) {
  const item = document.createElement("li");
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = 2 * SIZE;
  const c = contextOf(canvas);
  c.scale(2, 2);
  drawMark(c, shape, SIZE / 2, SIZE / 2, 7, colours[colour], colours.rim);
  item.append(canvas, count > 0 ? `${name}, ${count}` : `${name}, when zoomed`);
  return item;
}
