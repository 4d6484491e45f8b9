// Control for drawing a curve, with a pointer over the field or with handles and keys.

import { Curve, HANDLES } from "./curve.js";
import { boxOf, newSvg } from "./drawing.js";
import { button, make } from "./make.js";
import { SvgContext } from "./svg.js";

/** Return the controls of the task `draw`. */
export function drawCurve({ answer }) {
  const curve = new Curve();
  const svg = newSvg();
  svg.setAttribute("aria-hidden", "true");
  const draw = () => {
    const { width, height } = field.getBoundingClientRect();
    const { x, y } = boxOf(width, height);
    const c = new SvgContext(svg);
    c.beginPath();
    const last = curve.values.length - 1;
    curve.values.forEach((level, i) => c.lineTo(x(i / last), y(level)));
    c.strokeStyle = curve.drawn ? "var(--hand)" : "var(--line)";
    c.lineWidth = 3;
    c.stroke();
    c.show();
    handles.forEach((one, i) => {
      const percent = Math.round(100 * curve.handle(i));
      one.value = String(percent);
      one.style.left = `${x(i / (HANDLES - 1))}px`;
      one.style.top = `${y(curve.handle(i))}px`;
    });
  };
  const handles = Array.from({ length: HANDLES }, (_, i) => make("input", {
    type: "range", min: 0, max: 100, step: 5, value: 0, class: "handle",
    "aria-label": `Height at ${Math.round((100 * i) / (HANDLES - 1))} percent`,
    on: { input: ({ target }) => {
      curve.setHandle(i, Number(target.value) / 100);
      draw();
    } },
  }));
  const field = make("div", { class: "sketch" }, svg, ...handles);
  const at = ({ clientX, clientY }) => {
    const { left, top, width, height } = field.getBoundingClientRect();
    const box = boxOf(width, height);
    return [box.place(clientX - left), box.level(clientY - top)];
  };
  let down = false;
  field.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    field.setPointerCapture(event.pointerId);
    down = true;
    curve.begin(...at(event));
    draw();
  });
  field.addEventListener("pointermove", (event) => {
    if (!down) return;
    for (const one of event.getCoalescedEvents?.() ?? [event]) curve.move(...at(one));
    draw();
  });
  for (const over of ["pointerup", "pointercancel", "lostpointercapture"]) {
    field.addEventListener(over, () => {
      down = false;
    });
  }
  const clear = button("Clear", () => {
    curve.clear();
    draw();
  });
  const done = button("This is my drawing", () => answer(curve.response), {
    disabled: true, class: "done",
  });
  new ResizeObserver(draw).observe(field);
  return {
    element: make("div", { class: "measure" },
      make("p", { class: "hint", text: "Draw it with a finger, or Tab to a column and use the arrow keys." }),
      make("div", { role: "group", "aria-label": "Your drawing" }, field), clear, done),
    enable() {
      done.disabled = false;
    },
  };
}
