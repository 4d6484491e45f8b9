// A stimulus drawn: its curve and its events' marks, for the conditions that are seen.

import { drawMark } from "./marks.js";
import { SvgContext } from "./svg.js";
import { make } from "./make.js";

const MARGIN = 18; // px, on all sides
const MARK = 7;
const SVG = "http://www.w3.org/2000/svg";

export const newSvg = () => /** @type {any} */ (document.createElementNS(SVG, "svg"));

/** Where a place (0 to 1) and a level (0 to 1) are in a box of so many px. */
export const boxOf = (width, height) => ({
  x: (place) => MARGIN + (width - 2 * MARGIN) * place,
  y: (level) => height - MARGIN - (height - 2 * MARGIN) * level,
  place: (x) => Math.min(Math.max((x - MARGIN) / Math.max(width - 2 * MARGIN, 1), 0), 1),
  level: (y) => Math.min(Math.max((height - MARGIN - y) / Math.max(height - 2 * MARGIN, 1), 0), 1),
});

/** Draw `view` (`stimuli/KEY.json`) into an SVG; the colours are the style sheet's. */
export function drawTimeline(svg, view, kinds) {
  const { width, height } = svg.getBoundingClientRect();
  const { x, y } = boxOf(width, height);
  const c = new SvgContext(svg);
  const last = view.level.length - 1;
  const course = () => {
    c.beginPath();
    view.level.forEach((level, i) => c.lineTo(x(i / last), y(level)));
  };
  course();
  c.lineTo(x(1), y(0));
  c.lineTo(x(0), y(0));
  c.fillStyle = "var(--fill)";
  c.fill();
  course();
  c.strokeStyle = "var(--curve)";
  c.lineWidth = 1.75;
  c.stroke();
  for (const { position: place, kind } of view.events) {
    const { shape, colour } = kinds[kind];
    const up = y(view.level[Math.round(place * last)]);
    drawMark(c, shape, x(place), Math.min(up, height - MARGIN), MARK, `var(--${colour})`, "var(--rim)");
  }
  c.show();
}

/** A field in which a stimulus and its cursor are seen, or nothing. */
export class View {
  constructor(kinds) {
    this.kinds = kinds;
    this.view = null;
    this.svg = newSvg();
    this.cursor = make("i", { class: "cursor", hidden: true });
    this.element = make("div", { class: "view", "aria-hidden": "true" }, this.svg, this.cursor);
    this.resized = new ResizeObserver(() => this.show(this.view));
    this.resized.observe(this.element);
  }

  /** Draw a stimulus; null for nothing. */
  show(view) {
    this.view = view;
    if (view === null) this.svg.replaceChildren();
    else drawTimeline(this.svg, view, this.kinds);
  }

  at(cursor) {
    const { x } = boxOf(this.element.clientWidth, this.element.clientHeight);
    this.cursor.hidden = this.view === null;
    this.cursor.style.transform = `translateX(${x(cursor).toFixed(1)}px)`;
  }

  end() {
    this.resized.disconnect();
  }
}

/** What the marks mean: a list of the kinds that a view has. */
export function legendOf(kinds) {
  return make("ul", { class: "legend" }, ...Object.values(kinds).map(({ name: words, shape, colour }) => {
    const svg = newSvg();
    svg.setAttribute("viewBox", "0 0 24 24");
    svg.setAttribute("aria-hidden", "true");
    const c = new SvgContext(svg);
    drawMark(c, shape, 12, 12, MARK, `var(--${colour})`, "var(--rim)");
    c.show();
    return make("li", {}, svg, make("span", { text: words }));
  }));
}
