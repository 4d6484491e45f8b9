// The marks of the event kinds: chips beside the picture and in the list of events, which hide a kind.

import { button, byId, made } from "./dom.js";
import { drawKind, markOf } from "./marks.js";
import { COLOURS } from "./picture.js";
import { titleParts } from "./scores.js";
import { SvgContext } from "./svg.js";
import { whenZoomed } from "./words.js";

/** @import { Info, Kind, Mark, View } from "../types" */

const SIZE = 20; // px of a mark

/**
 * Return the kinds that are listed, the most important first. Ticks of time need no legend.
 * @param {Info} info
 * @returns {[string, Kind][]}
 */
export const listedKinds = (info) => Object.entries(info.kinds)
  .filter(([, kind]) => kind.count > 0 || kind.shape !== "bar")
  .sort(([, a], [, b]) => rankOf(a) - rankOf(b));

/** Return the rank of a kind: kinds of windows alone are behind others, ticks of time the last. @param {Kind} kind */
const rankOf = ({ shape, count }) => (shape === "bar" ? 2 : Number(count === 0));

/** @param {Kind} kind */
const nameOf = ({ name }) => name.charAt(0).toUpperCase() + name.slice(1);

/**
 * Return an SVG with a mark.
 * @param {Mark} mark
 */
export function markIcon(mark) {
  const svg = /** @type {SVGSVGElement} */ (document.createElementNS(byId("canvas").namespaceURI, "svg"));
  svg.classList.add("mark");
  svg.setAttribute("viewBox", `0 0 ${SIZE} ${SIZE}`);
  svg.setAttribute("aria-hidden", "true");
  const c = new SvgContext(svg);
  drawKind(c, mark, SIZE / 2, SIZE / 2, 6, Object.fromEntries(COLOURS.map((name) => [name, `var(--${name})`])));
  c.show();
  return svg;
}

/**
 * Return one toggle for each kind, which calls `toggle(id)`.
 * @param {Info} info
 * @param {Set<string>} hidden
 * @param {(id: string) => void} toggle
 */
export function chipsOf(info, hidden, toggle) {
  return listedKinds(info).map(([id, kind]) => {
    const chip = button("chip", () => toggle(id), markIcon(markOf(id, kind)),
      kind.count > 0 ? `${nameOf(kind)} ${kind.count}` : nameOf(kind));
    chip.dataset.kind = id;
    chip.setAttribute("aria-pressed", String(!hidden.has(id)));
    return chip;
  });
}

/**
 * Show the title; the names of a match stand beside the marks of their goals, and what follows below.
 * @param {Info} info
 */
export function showTitle(info) {
  const parts = titleParts(info);
  const [one, two] = ["one", "two"].map((colour, i) => markIcon({ shape: "circle", colour, isRing: i === 1 }));
  const between = parts?.between.replace(/(\d)-(?=\d)/, "$1\u2013") ?? "";
  byId("title").replaceChildren(...(parts ? [one, parts.one, between, two, parts.two] : [info.title]));
}

/** Hide the chips that have no room beside the picture; the list of events has them all. */
export function fitLegend() {
  const legend = byId("legend");
  const chips = /** @type {HTMLElement[]} */ ([...legend.children]);
  for (const chip of chips) chip.hidden = false;
  const cut = chips.filter((chip) => chip.offsetTop + chip.offsetHeight > legend.offsetTop + legend.clientHeight + 1
    || chip.offsetLeft + chip.offsetWidth > legend.offsetLeft + legend.clientWidth + 1);
  for (const chip of cut) chip.hidden = true;
}

/**
 * Fill a list with one item per kind.
 * @param {Element} list
 * @param {Info} info
 */
export function showLegend(list, info) {
  list.replaceChildren(...listedKinds(info).map(([id, kind]) => {
    const count = kind.count > 0 ? `${nameOf(kind)} ${kind.count}` : whenZoomed(nameOf(kind));
    return made("li", {}, markIcon(markOf(id, kind)), count);
  }));
}
