// Description of the data in the settings.

import { listedKinds } from "./legend.js";

/** @import { Info, View } from "../types" */

const STRETCHED = "Spans of the groove last equally long: where they are wider, time is stretched to separate "
  + "close events";

/**
 * Fill `about` with sentences on the data.
 * @param {HTMLElement} about
 * @param {Info} info
 * @param {View} view
 */
export function showAbout(about, info, view) {
  const shapes = listedKinds(info).map(([, { shape }]) => shape);
  const shared = new Set(shapes).size < shapes.length ? "Some kinds have the same mark" : "";
  const axis = view.angle_map ? STRETCHED : "";
  about.textContent = [info.provenance, ...info.notes, axis, shared].filter(Boolean).join(". ");
}
