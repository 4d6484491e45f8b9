// What moves, as elements that the browser's compositor moves: the cursor that sticks, the finger
// ahead of it, the disk's needle and its two shafts. Nothing is painted again when they do.

import { by } from "./dom.js";
import { angleOf } from "./geometry.js";
import { levelAt, resistanceAt } from "./layer.js";

/** @import { Geometry, Info, View } from "../types" */

const NAMES = ["cursor", "dot", "halo", "finger", "pull", "disk", "rub", "needle", "grip"];
const STEPS = 20; // of a size

/** @param {number} place */
const degrees = (place) => `${((angleOf(place) * 180) / Math.PI).toFixed(2)}deg`;

export class Moving {
  constructor() {
    this.parts = Object.fromEntries(NAMES.map((name) => [name, by(name)]));
    /** @type {Map<string, unknown>} */
    this.set = new Map(); // what was set last, so that nothing is set twice
  }

  /**
   * Lay it out: another size.
   * @param {Geometry} geometry
   */
  place({ disk, top, bottom }) {
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
   * `state`: cursor and hand (0 to 1), touching.
   * @param {Geometry} g
   * @param {View} view
   * @param {{ cursor: number, hand: number, touching: boolean }} state
   * @param {Info} info
   */
  show(g, view, { cursor, hand, touching }, info) {
    const x = g.x(cursor);
    const y = g.y(levelAt(view, cursor));
    const held = Math.log10(Math.max(1, resistanceAt(view, cursor) / info.bare_friction)) / 2;
    const grip = Math.min(held, 1);
    this.put("cursor", `translateX(${x.toFixed(1)}px)`);
    this.put("dot", `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`);
    // as large as the friction under it, in steps that an eye takes for none
    const size = Math.ceil(STEPS * grip) / STEPS;
    this.put("halo", `scale(${0.4 + 0.6 * size})`);
    this.visible("finger", touching);
    this.visible("pull", touching);
    if (touching) {
      const to = g.x(hand);
      this.put("finger", `translateX(${to.toFixed(1)}px)`);
      const width = Math.abs(to - x).toFixed(1);
      this.put("pull", `translateX(${Math.min(x, to).toFixed(1)}px) scaleX(${width})`);
    }
    if (g.disk === null) return;
    this.put("needle", `rotate(${degrees(cursor)})`);
    this.put("rub", `scale(${0.35 + 0.65 * size})`);
    this.visible("grip", touching);
    if (touching) this.put("grip", `rotate(${degrees(hand)})`);
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
   * @param {boolean} shown
   */
  visible(name, shown) {
    const key = `${name} shown`;
    if (this.set.get(key) === shown) return;
    this.set.set(key, shown);
    this.parts[name].style.visibility = shown ? "visible" : "hidden";
  }
}
