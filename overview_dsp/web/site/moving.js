// Moving parts of the picture: line and dot of the finger, ring and needle of the disk. They are
// elements that the browser's compositor moves without painting.

import { byId } from "./dom.js";
import { angleOf } from "./geometry.js";
import { levelAt, resistanceAt } from "./layer.js";

/** @import { Geometry, Info, View } from "../types" */

const NAMES = /** @type {const} */ ([
  "cursor", "dot", "ring", "halo", "finger", "pull", "disk", "rub", "needle", "grip",
]);
const STEPS = 20; // size steps of the friction marks

/** @param {number} position */
const degrees = (position) => `${((angleOf(position) * 180) / Math.PI).toFixed(2)}deg`;

export class Moving {
  constructor() {
    this.parts = Object.fromEntries(NAMES.map((name) => [name, byId(name)]));
    /** @type {Map<string, unknown>} */
    this.set = new Map(); // last values, to set only changes
  }

  /**
   * Lay out the parts for a new geometry.
   * @param {Geometry} geometry
   */
  layOut({ disk, top, bottom }) {
    const { cursor, disk: plate } = this.parts;
    cursor.style.top = `${top - 14}px`;
    cursor.style.height = `${bottom - top + 14}px`;
    this.parts.finger.style.top = this.parts.pull.style.top = `${top - 14}px`;
    plate.hidden = disk === null;
    if (disk !== null) {
      plate.style.left = `${disk.x - disk.radius}px`;
      plate.style.top = `${disk.y - disk.radius}px`;
      plate.style.width = plate.style.height = `${2 * disk.radius}px`;
    }
    this.set.clear();
  }

  /**
   * `cursor` is the disk's position (0 to 1), `input` that which is read out.
   * @param {Geometry} g
   * @param {View} view
   * @param {{ cursor: number, input: number, touching: boolean }} state
   * @param {Info} info
   */
  show(g, view, { cursor, input, touching }, info) {
    const x = g.x(cursor);
    const to = g.x(input);
    const [level, inputLevel] = [levelAt(view, cursor), levelAt(view, input)];
    const friction = Math.log10(Math.max(1, resistanceAt(view, cursor) / info.base_friction)) / 2;
    const grip = Math.min(friction, 1);
    this.put("cursor", `translateX(${to.toFixed(1)}px)`);
    this.put("dot", `translate(${to.toFixed(1)}px, ${g.y(inputLevel ?? 0).toFixed(1)}px)`);
    this.setVisible("dot", inputLevel !== null);
    this.put("ring", `translate(${x.toFixed(1)}px, ${g.y(level ?? 0).toFixed(1)}px)`);
    this.setVisible("ring", level !== null);
    // sized by the friction, in steps too small to see
    const size = Math.ceil(STEPS * grip) / STEPS;
    this.put("halo", `scale(${0.4 + 0.6 * size})`);
    if (this.set.get("touching") !== touching) {
      this.set.set("touching", touching);
      byId("stage").classList.toggle("released", !touching);
    }
    this.setVisible("finger", touching);
    this.setVisible("pull", touching);
    if (touching) {
      this.put("finger", `translateX(${to.toFixed(1)}px)`);
      const width = Math.abs(to - x).toFixed(1);
      this.put("pull", `translateX(${Math.min(x, to).toFixed(1)}px) scaleX(${width})`);
    }
    if (g.disk === null) return;
    this.put("needle", `rotate(${degrees(cursor)})`);
    this.put("rub", `scale(${0.35 + 0.65 * size})`);
    this.setVisible("grip", touching);
    if (touching) this.put("grip", `rotate(${degrees(input)})`);
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
