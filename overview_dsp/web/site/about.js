// Description of the data in the settings.

import { listedKinds } from "./legend.js";
import { SAME_MARKS, STRETCHED } from "./page_words.js";

/** @import { Info, View } from "../types" */

/**
 * Fill `about` with sentences on the data.
 * @param {HTMLElement} about
 * @param {Info} info
 * @param {View} view
 */
export function showAbout(about, info, view) {
  const shapes = listedKinds(info).map(([, { shape }]) => shape);
  const shared = new Set(shapes).size < shapes.length ? SAME_MARKS : "";
  const axis = view.angle_map ? STRETCHED : "";
  about.textContent = [info.provenance, ...info.notes, axis, shared].filter(Boolean).join(". ");
}
