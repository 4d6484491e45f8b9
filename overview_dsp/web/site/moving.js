// Moving parts of the picture: line and dot of the finger, ring, disk and spring. They are elements that
// the browser's compositor moves without painting; only what has changed is set.

import { byId } from "./dom.js";
import { angleOf } from "./geometry.js";
import { levelAt } from "./layer.js";

/** @import { Geometry, View } from "../types" */

const NAMES = /** @type {const} */ ([
  "at-disk", "at-input", "cursor", "dot", "ring", "finger", "pull", "disk", "needle", "torque", "passed", "passed-curve",
]);
const LEAST = 1e-3; // position of a disk that was moved
const PULL = 100; // width (px) of the spring's drawing
const ARC = 34; // length of the arc at the reference torque, of 100 around the disk, as in the page
const TURN = 3.6; // degrees

export class Moving {
  constructor() {
    this.parts = Object.fromEntries(NAMES.map((name) => [name, byId(name)]));
    /** @type {Map<string, unknown>} */
    this.set = new Map(); // last values, to set only changes
    this.wasTouched = false; // before a touch nothing is read out
  }

  /**
   * Lay out the parts for a new geometry.
   * @param {Geometry} geometry
   */
  layOut({ dial, groove, radius, still, width }) {
    const { disk } = this.parts;
    const hint = byId("hint");
    const size = dial?.radius ?? radius;
    this.parts.cursor.style.height = `${groove}px`;
    this.parts.finger.style.top = this.parts.pull.style.top = hint.style.top = `${groove}px`;
    hint.style.setProperty("--radius", `${radius}px`);
    disk.style.setProperty("--radius", `${size}px`);
    disk.style.top = `${dial?.y ?? groove}px`;
    byId("disk").hidden = still;
    disk.classList.toggle("dial", dial !== null);
    byId("ring").hidden = still;
    this.parts.passed.style.left = `${-width}px`;
    this.parts.passed.style.width = this.parts["passed-curve"].style.width = `${width}px`;
    this.set.clear();
  }

  /**
   * `cursor` is the disk's position (0 to 1), `input` that which is read out, `torque` a share of the
   * reference torque.
   * @param {Geometry} g
   * @param {View} view
   * @param {{ cursor: number, input: number, touching: boolean, torque: number }} state
   */
  show(g, view, { cursor, input, touching, torque }) {
    const x = g.x(cursor);
    const to = g.x(input);
    const [level, inputLevel] = [levelAt(view, cursor), levelAt(view, input)];
    this.put("at-disk", `translateX(${x.toFixed(1)}px)`);
    this.put("at-input", `translateX(${to.toFixed(1)}px)`);
    this.put("dot", `translateY(${g.y(inputLevel ?? 0).toFixed(1)}px)`);
    this.wasTouched ||= touching || cursor > LEAST;
    this.setVisible("cursor", this.wasTouched);
    this.setVisible("dot", this.wasTouched && inputLevel !== null);
    this.put("passed-curve", `translateX(${(g.width - x).toFixed(1)}px)`);
    if (this.set.get("touching") !== touching) {
      this.set.set("touching", touching);
      byId("stage").classList.toggle("released", !touching);
    }
    this.setVisible("finger", touching || (this.wasTouched && input > 0));
    this.setVisible("pull", touching && !g.still && g.dial === null);
    if (g.still) return;
    this.put("ring", `translateY(${g.y(level ?? 0).toFixed(1)}px)`);
    this.setVisible("ring", level !== null);
    if (touching && g.dial === null) this.put("pull", `scaleX(${((to - x) / PULL).toFixed(3)})`);
    this.put("disk", g.dial === null ? "none" : `translateX(${(g.dial.x - x).toFixed(1)}px)`);
    this.put("needle", `rotate(${((angleOf(cursor) * 180) / Math.PI).toFixed(1)}deg)`);
    // cube root: shows both the surface and goals
    const length = Math.round(ARC * Math.min(Math.cbrt(Math.abs(torque)), 1));
    this.put("torque", `rotate(${((length - ARC) * TURN).toFixed(1)}deg)`);
  }

  /**
   * @param {string} name
   * @param {string} transform
   */
  put(name, transform) {
    if (this.set.get(name) === transform) return;
    this.set.set(name, transform);
    this.parts[name].style.transform = transform;
  }

  /**
   * @param {string} name
   * @param {boolean} isVisible
   */
  setVisible(name, isVisible) {
    const key = `${name} visible`;
    if (this.set.get(key) === isVisible) return;
    this.set.set(key, isVisible);
    this.parts[name].style.visibility = isVisible ? "visible" : "hidden";
  }
}
