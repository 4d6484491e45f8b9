// The preset bench: a preset's parameters under sliders, felt at once, against another (A and B),
// kept as a file. What they mean is computed by the server, by the code that a native engine runs.

import { COURSE, drawingOf, MAP } from "./bench_drawing.js";
import { rowOf } from "./bench_rows.js";
import { by } from "./dom.js";
import { ask, post } from "./session.js";

/** @import { Drawing, EventKind, Parameter, Preset } from "../types" */
/** @import { Hand } from "./hand.js" */
/** @typedef {[Parameter, Record<string, any>, string]} Row a parameter, whose value, its key there */

/** @param {string} path */
const json = async (path) => (await ask(path)).json();
const ELSEWHERE = ["twist", "follow"]; // a sensor's twist, a host's map: nothing of the page's
const ANGLE_MAP = "surface.angle_map";
const NAME = /^[\w-]+$/; // others are no preset's, or would lead elsewhere
const TAKEN = "there already";
/** @type {(a: unknown, b: unknown) => boolean} */
const isSame = (a, b) => JSON.stringify(a) === JSON.stringify(b);

export class Bench {
  /**
   * `feel(before, after, surface)` makes the change sound; `surface`: whether that differs.
   * @param {(before: Preset, after: Preset, surface: boolean) => Promise<void>} feel
   * @param {Hand} hand
   */
  constructor(feel, hand) {
    this.feel = feel;
    this.hand = hand;
    const { onchange } = hand;
    hand.onchange = () => {
      onchange();
      if (hand.holder === null) this.settle();
    };
    /** @type {Preset[] | null} */
    this.sides = null; // the presets of A and B
    this.side = 1;
    /** @type {Preset | null} */
    this.sounding = null;
    this.busy = false;
    by("bench-close").addEventListener("click", () => this.toggle(false));
    by("bench-a").addEventListener("click", () => this.choose(0));
    by("bench-b").addEventListener("click", () => this.choose(1));
    by("bench-preset").addEventListener("change", () => this.load(by("bench-preset").value));
    by("bench-name").addEventListener("input", () => this.offer(false));
    by("bench-download").addEventListener("click", () => this.guarded(() => this.download()));
    by("bench-save").addEventListener("click", () => this.guarded(() => this.save()));
  }

  get preset() {
    return this.sides[this.side];
  }

  /** @param {boolean} open */
  async toggle(open) {
    if (open && this.sides === null && !(await this.guarded(() => this.begin()))) return;
    by("bench").hidden = !open;
    document.documentElement.classList.toggle("tuning", open);
    (open ? by("bench-title") : by("slider")).focus();
  }

  get open() {
    return !by("bench").hidden;
  }

  /** Another preset sounds: the next opening begins with that. */
  forget() {
    this.sides = null;
    by("bench-preset").replaceChildren();
  }

  /**
   * A preset saved on the desk is felt on the side that wasn't: what was tuned here stays on its own.
   * `sounds`: whether it does already.
   * @param {Preset} preset
   * @param {boolean} sounds
   */
  async take(preset, sounds) {
    if (isSame(preset, this.preset)) return;
    if (sounds) this.sounding = structuredClone(preset);
    const side = 1 - this.side;
    this.sides[side] = preset;
    const names = [...by("bench-preset").options].map(({ value }) => value);
    if (!names.includes(preset.name)) by("bench-preset").append(new Option(preset.name));
    await this.choose(side);
    const [own, its] = side === 0 ? ["B", "A"] : ["A", "B"];
    const line = `${preset.name} was saved on the desk: it is ${its}, what you tuned is ${own}`;
    by("bench-told").textContent ||= line;
  }

  /**
   * Feel another preset by its name, without the bench's being open.
   * @param {string} name
   */
  async use(name) {
    if (this.sides === null) await this.begin();
    await this.load(name);
  }

  async begin() {
    const [{ preset, parameters }, { bundled, own }] = await Promise.all([
      json("data/preset"), json("data/presets"),
    ]);
    /** @type {Map<string, Parameter>} */
    this.table = new Map(parameters.map((/** @type {Parameter} */ one) => [one.id, one]));
    this.sides = [preset, structuredClone(preset)];
    this.sounding = structuredClone(preset);
    const names = [...new Set([preset.name, ...own, ...bundled])];
    by("bench-preset").append(...names.map((name) => new Option(name)));
    by("bench-name").value = `my-${preset.name}`.slice(0, 64);
    this.choose(1);
  }

  /**
   * Feel A (0) or B (1).
   * @param {number} side
   */
  choose(side) {
    this.side = side;
    by("bench-a").setAttribute("aria-pressed", String(side === 0));
    by("bench-b").setAttribute("aria-pressed", String(side === 1));
    by("bench-preset").value = this.preset.name;
    this.show();
    return this.changed();
  }

  /**
   * Begin this side from another preset.
   * @param {string} name
   */
  load(name) {
    return this.guarded(async () => {
      const { preset } = await json(`data/preset?name=${encodeURIComponent(name)}`);
      this.sides[this.side] = preset;
      this.show();
      this.changed();
    });
  }

  // --- rows -------------------------------------------------------------------------------------

  show() {
    const opened = by("bench-rows").querySelectorAll("details[open]");
    const open = new Set([...opened].map((/** @type {Element} */ one) => one.id));
    const { values, kinds } = this.preset;
    /** @type {Map<string, Row[]>} */
    const sections = new Map();
    /** @type {Map<string, [{ points: number[] }, Drawing]>} */
    const drawn = new Map([["surface", [this.preset, MAP]]]);
    for (const [id, known] of this.table) {
      if (["kinds", ...ELSEWHERE].includes(id.split(".")[0])) continue;
      const name = id.split(".")[0];
      sections.set(name, [...(sections.get(name) ?? []), [known, values, id]]);
    }
    for (const [name, kind] of Object.entries(kinds)) {
      sections.set(`event: ${name.replaceAll("_", " ")}`, this.kindRows(kind));
      drawn.set(`event: ${name.replaceAll("_", " ")}`, [kind, COURSE]);
    }
    by("bench-rows").replaceChildren(
      ...[...sections].map(([name, rows]) => (
        this.section(name, rows, open, drawn.get(name)))),
    );
  }

  /**
   * @param {EventKind} kind
   * @returns {Row[]}
   */
  kindRows(kind) {
    const known = (/** @type {string} */ id) => this.table.get(`kinds.NAME.${id}`);
    /** @type {Row[]} */
    const rows = Object.keys(kind)
      .filter((key) => known(key) && kind[key] !== null)
      .map((key) => [known(key), kind, key]);
    kind.modes.forEach((mode, i) => {
      for (const key of Object.keys(mode)) {
        const row = known(`modes.${key}`);
        rows.push([{ ...row, doc: `Mode ${i + 1}. ${row.doc}` }, mode, key]);
      }
    });
    return rows;
  }

  /**
   * A section, whose rows are made when it is opened; `drawn`: whose points can be drawn in it.
   * @param {string} name
   * @param {Row[]} rows
   * @param {Set<string>} open
   * @param {[{ points: number[] }, Drawing] | undefined} drawn
   */
  section(name, rows, open, drawn) {
    const details = document.createElement("details");
    details.id = `section ${name}`;
    const summary = document.createElement("summary");
    summary.textContent = name;
    details.append(summary);
    const fill = () => {
      if (!details.open || details.children.length > 1) return;
      details.append(
        ...rows.map(([known, place, key]) =>
          rowOf(known, place, key, () => this.changed()),
        ),
      );
      if (drawn) details.append(drawingOf(...drawn, () => this.changed()));
    };
    details.addEventListener("toggle", fill);
    details.open = open.has(details.id);
    fill();
    return details;
  }

  // --- felt at once -----------------------------------------------------------------------------

  /** Send the latest; what came while one was under way follows it, the rest is left out. */
  async changed() {
    this.offer(false);
    if (this.busy) {
      this.again = true;
      return;
    }
    this.busy = true;
    do {
      this.again = false;
      const after = structuredClone(this.preset);
      // no place moves under a hand
      if (this.hand.holder !== null) after.values[ANGLE_MAP] = this.sounding.values[ANGLE_MAP];
      const surface = this.differs(this.sounding, after);
      if (surface === null) continue;
      if (await this.guarded(() => this.feel(this.sounding, after, surface))) this.sounding = after;
    } while (this.again);
    this.busy = false;
  }

  /** The map of the preset that was chosen under a hand, once that has let go. */
  settle() {
    if (this.sides && this.sounding.values[ANGLE_MAP] !== this.preset.values[ANGLE_MAP]) this.changed();
  }

  /**
   * Whether the surface of two presets differs; null if nothing does.
   * @param {Preset} before
   * @param {Preset} after
   */
  differs(before, after) {
    const ids = Object.keys(after.values).filter((id) => before.values[id] !== after.values[id]);
    if (!isSame([before.kinds, before.points], [after.kinds, after.points])) return true;
    if (ids.some((id) => this.table.get(id).surface)) return true;
    return ids.length > 0 || before.name !== after.name ? false : null;
  }

  // --- files ------------------------------------------------------------------------------------

  async toml() {
    return (await post("preset/toml", this.preset)).text();
  }

  get name() {
    return by("bench-name").value.trim();
  }

  async download() {
    const file = new Blob([await this.toml()], { type: "application/toml" });
    const link = document.createElement("a");
    link.href = URL.createObjectURL(file);
    link.download = `${this.name || this.preset.name}.toml`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1e4);
  }

  async save() {
    if (this.saving) return; // pressed twice
    if (!NAME.test(this.name)) {
      throw new Error(`${this.name || "nothing"} is no name: letters, digits, - and _`);
    }
    this.saving = true;
    try {
      await this.put(await this.toml());
    } finally {
      this.saving = false;
    }
  }

  /** @param {string} body */
  async put(body) {
    const path = `preset/${encodeURIComponent(this.name)}${this.replaces ? "?replace=1" : ""}`;
    try {
      await ask(path, { method: "PUT", body });
    } catch (error) {
      const taken = error.message.includes(TAKEN);
      this.offer(taken);
      if (!taken) throw error;
      throw new Error(`${this.name} is there already: replace it, or give another name`);
    }
    this.offer(false);
    this.say(`kept as ${this.name}`);
  }

  /**
   * Offer to replace the file of that name, or not.
   * @param {boolean} replaces
   */
  offer(replaces) {
    this.replaces = replaces;
    by("bench-save").textContent = replaces ? "Replace it" : "Save";
  }

  /** @param {string} text */
  say(text) {
    by("bench-told").textContent = text;
  }

  /**
   * Do it; whether it went well. A refusal is told.
   * @param {() => unknown} act
   */
  async guarded(act) {
    this.say("");
    try {
      await act();
      return true;
    } catch (error) {
      this.say(error.message);
      return false;
    }
  }
}
