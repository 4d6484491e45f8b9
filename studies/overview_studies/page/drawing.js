// Drawing of a stimulus for visual conditions: intensity curve and event marks.

import { drawMark } from "./marks.js";
import { SvgContext } from "./svg.js";
import { make } from "./make.js";

const MARGIN = 18; // px, on all sides
const MARK = 7;
const SVG = "http://www.w3.org/2000/svg";

export const newSvg = () => /** @type {any} */ (document.createElementNS(SVG, "svg"));

/** Return conversions between pixels and positions or levels (0 to 1). */
export const boxOf = (width, height) => ({
  x: (place) => MARGIN + (width - 2 * MARGIN) * place,
  y: (level) => height - MARGIN - (height - 2 * MARGIN) * level,
  place: (x) => Math.min(Math.max((x - MARGIN) / Math.max(width - 2 * MARGIN, 1), 0), 1),
  level: (y) => Math.min(Math.max((height - MARGIN - y) / Math.max(height - 2 * MARGIN, 1), 0), 1),
});

/** Draw `view` (`stimuli/KEY.json`) into an SVG, with the colours of the style sheet. */
export function drawTimeline(svg, view, kinds) {
  const { width, height } = svg.getBoundingClientRect();
  const { x, y } = boxOf(width, height);
  const c = new SvgContext(svg);
  const last = view.level.length - 1;
  const traceCurve = () => {
    c.beginPath();
    view.level.forEach((level, i) => c.lineTo(x(i / last), y(level)));
  };
  traceCurve();
  c.lineTo(x(1), y(0));
  c.lineTo(x(0), y(0));
  c.fillStyle = "var(--fill)";
  c.fill();
  traceCurve();
  c.strokeStyle = "var(--curve)";
  c.lineWidth = 1.75;
  c.stroke();
  for (const { position, kind } of view.events) {
    const { shape, colour } = kinds[kind];
    const up = y(view.level[Math.round(position * last)]);
    drawMark(c, shape, x(position), Math.min(up, height - MARGIN), MARK, `var(--${colour})`, "var(--rim)");
  }
  c.show();
}

/** Field that shows a stimulus and its cursor, or stays empty. */
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

  /** Draw a stimulus; null clears the field. */
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

/** Return a legend of the event kinds. */
export function legendOf(kinds) {
  return make("ul", { class: "legend" }, ...Object.values(kinds).map(({ name, shape, colour }) => {
    const svg = newSvg();
    svg.setAttribute("viewBox", "0 0 24 24");
    svg.setAttribute("aria-hidden", "true");
    const c = new SvgContext(svg);
    drawMark(c, shape, 12, 12, MARK, `var(--${colour})`, "var(--rim)");
    c.show();
    return make("li", {}, svg, make("span", { text: name }));
  }));
}
