// The preset editor: sliders for all parameters, with two versions (A and B) to compare.
// The server computes every change, with the same code as a native engine.

import { PROFILE, drawingOf, MAP } from "./editor_drawing.js";
import { labelOf, rowOf, valueText } from "./editor_rows.js";
import { byId, made, on } from "./dom.js";
import { request, post } from "./session.js";

/** @import { Drawing, EventKind, Parameter, Preset } from "../types" */
/** @import { CombinedInput } from "./combined_input.js" */
/** @typedef {[Parameter, Record<string, any>, string]} Row parameter, object with its value, key in it */

/** @param {string} path */
const json = async (path) => (await request(path)).json();
const HIDDEN_SECTIONS = ["twist", "follow"]; // sections that only concern sensors and hosts
const ANGLE_MAP = "surface.angle_map";
const ONE_STEP_MS = 700; // changes within this time are undone together
const NAME = /^[\w-]+$/; // allowed in a preset's file name
const EXISTS = "already exists";
/** @type {(a: unknown, b: unknown) => boolean} */
const isSame = (a, b) => JSON.stringify(a) === JSON.stringify(b);

export class PresetEditor {
  /**
   * `applyChange(before, after, surface)` makes a change; `surface` is true if the surface differs.
   * @param {(before: Preset, after: Preset, surface: boolean) => Promise<void>} applyChange
   * @param {CombinedInput} input
   */
  constructor(applyChange, input) {
    this.applyChange = applyChange;
    this.input = input;
    const { onchange } = input;
    input.onchange = () => {
      onchange();
      if (input.active === null) this.applyHeldMap();
    };
    /** @type {Preset[] | null} */
    this.sides = null; // the presets of A and B
    this.side = 1;
    /** @type {string[]} */
    this.history = []; // earlier states of A and B as JSON, for Undo
    this.state = ""; // the newest one
    this.changedAt = -Infinity;
    /** @type {Preset | null} */
    this.playing = null;
    /** @type {Map<string, Parameter>} */
    this.table = new Map();
    this.busy = this.isSearching = false;
    /** @type {string[]} */
    this.openSections = [];
    on("editor-close", "click", () => this.toggle(false));
    on("editor-a", "click", () => this.choose(0));
    on("editor-b", "click", () => this.choose(1));
    on("editor-undo", "click", () => this.undo());
    on("editor-find", "input", () => this.show());
    on("editor-preset", "change", () => this.load(byId("editor-preset").value));
    on("editor-name", "input", () => this.offer(false));
    on("editor-download", "click", () => this.tryTo(() => this.download()));
    on("editor-save", "click", () => this.tryTo(() => this.save()));
  }

  /** The presets of A and B, once they are loaded. */
  get loaded() {
    if (this.sides === null) throw new Error("the editor was closed: open it again");
    return this.sides;
  }

  get preset() {
    return this.loaded[this.side];
  }

  /** @param {boolean} open */
  async toggle(open) {
    if (open && this.sides === null && !(await this.tryTo(() => this.begin()))) return;
    byId("editor").hidden = !open;
    document.documentElement.classList.toggle("tuning", open);
    (open ? byId("editor-title") : byId("slider")).focus();
  }

  get open() {
    return !byId("editor").hidden;
  }

  /** Start from the served preset when the editor opens again. */
  reset() {
    this.sides = null;
    byId("editor-preset").replaceChildren();
  }

  /**
   * Put a preset that was saved elsewhere on the side that isn't active; your changes stay on the other.
   * `sounds`: whether the preset is active already.
   * @param {Preset} preset
   * @param {boolean} sounds
   */
  async addSavedPreset(preset, sounds) {
    if (isSame(preset, this.preset)) return;
    if (sounds) this.playing = structuredClone(preset);
    const side = 1 - this.side;
    this.loaded[side] = preset;
    const names = [...byId("editor-preset").options].map(({ value }) => value);
    if (!names.includes(preset.name)) byId("editor-preset").append(new Option(preset.name));
    await this.choose(side);
    const [own, its] = side === 0 ? ["B", "A"] : ["A", "B"];
    const line = `${preset.name} was changed on the server and is now ${its}; your changes are ${own}`;
    byId("editor-message").textContent ||= line;
  }

  /**
   * Change to a preset by its name, even if the editor is closed; throw an Error if there is none.
   * @param {string} name
   */
  async use(name) {
    if (this.sides === null) await this.begin();
    if (!(await this.load(name))) throw new Error(byId("editor-message").textContent);
  }

  async begin() {
    const [{ preset, parameters }, { bundled, own }] = await Promise.all([
      json("data/preset"), json("data/presets"),
    ]);
    this.table = new Map(parameters.map((/** @type {Parameter} */ one) => [one.id, one]));
    this.sides = [preset, structuredClone(preset)];
    this.playing = structuredClone(preset);
    this.history = [];
    this.state = JSON.stringify(this.sides);
    const names = [...new Set([preset.name, ...own, ...bundled])];
    byId("editor-preset").append(...names.map((name) => new Option(name)));
    byId("editor-name").value = `my-${preset.name}`.slice(0, 64);
    this.choose(1);
  }

  /**
   * Activate A (0) or B (1).
   * @param {number} side
   */
  choose(side) {
    this.side = side;
    byId("editor-a").setAttribute("aria-pressed", String(side === 0));
    byId("editor-b").setAttribute("aria-pressed", String(side === 1));
    byId("editor-preset").value = this.preset.name;
    this.show();
    return this.changed();
  }

  /**
   * Load another preset into the active side.
   * @param {string} name
   */
  load(name) {
    return this.tryTo(async () => {
      const { preset } = await json(`data/preset?name=${encodeURIComponent(name)}`);
      this.loaded[this.side] = preset;
      this.show();
      this.changed();
    });
  }

  // --- rows -------------------------------------------------------------------------------------

  show() {
    const words = byId("editor-find").value.toLowerCase().split(/\s+/).filter(Boolean);
    if (!this.isSearching) { // a search opens sections, which close after it
      const opened = byId("editor-rows").querySelectorAll("details[open]");
      this.openSections = [...opened].map((/** @type {Element} */ one) => one.id);
    }
    this.isSearching = words.length > 0;
    const open = new Set(this.openSections);
    const { values, kinds } = this.preset;
    /** @type {Map<string, Row[]>} */
    const sections = new Map();
    /** @type {Map<string, [{ points: number[] }, Drawing]>} */
    const drawings = new Map([["surface", [this.preset, MAP]]]);
    for (const [id, parameter] of this.table) {
      if (["kinds", ...HIDDEN_SECTIONS].includes(id.split(".")[0])) continue;
      const name = id.split(".")[0];
      sections.set(name, [...(sections.get(name) ?? []), [parameter, values, id]]);
    }
    for (const [name, kind] of Object.entries(kinds)) {
      sections.set(`event: ${name.replaceAll("_", " ")}`, this.kindRows(kind));
      drawings.set(`event: ${name.replaceAll("_", " ")}`, [kind, PROFILE]);
    }
    if (this.isSearching) {
      drawings.clear();
      for (const [name, rows] of sections) {
        const found = rows.filter(([{ doc }, , key]) =>
          words.every((word) => `${name} ${labelOf(key)} ${doc}`.toLowerCase().includes(word)));
        if (found.length > 0) sections.set(name, found);
        else sections.delete(name);
        open.add(`section ${name}`);
      }
    }
    byId("editor-rows").replaceChildren(
      ...[...sections].map(([name, rows]) => (
        this.section(name, rows, open, drawings.get(name)))),
    );
    if (sections.size === 0) byId("editor-rows").textContent = "Nothing called that";
  }

  /** Keep the state before a change for Undo, and list what A and B differ in. */
  keepState() {
    const state = JSON.stringify(this.sides);
    const now = performance.now();
    if (state !== this.state) {
      if (now - this.changedAt > ONE_STEP_MS) this.history.push(this.state);
      this.state = state;
      this.changedAt = now;
    }
    byId("editor-undo").disabled = this.history.length === 0;
    const lines = this.differences();
    byId("editor-difference").textContent = lines.length === 0 ? "A and B are equal" : `A and B differ in ${lines.length}`;
    byId("editor-difference-list").replaceChildren(...lines.map((line) => made("li", {}, line)));
  }

  /** Return one line for each parameter in which A and B differ. */
  differences() {
    const [a, b] = this.loaded.map(({ values, kinds, points }) => {
      const shapes = Object.entries(kinds).flatMap(([name, kind]) =>
        Object.entries(kind).map(([key, value]) => [`${name}.${key}`, value]));
      return Object.fromEntries([...Object.entries(values), ["surface.points", points], ...shapes]);
    });
    const text = (/** @type {string} */ key, /** @type {any} */ value) => {
      if (value === undefined) return "none";
      if (typeof value !== "number") return typeof value === "object" ? JSON.stringify(value) : String(value);
      const own = this.table.get(key) ?? this.table.get(`kinds.NAME.${key.slice(key.indexOf(".") + 1)}`);
      return valueText(value, own?.unit ?? "");
    };
    return [...new Set([...Object.keys(a), ...Object.keys(b)])].filter((key) => !isSame(a[key], b[key]))
      .map((key) => `${key.replaceAll("_", " ")}: A ${text(key, a[key])}, B ${text(key, b[key])}`);
  }

  /** Return to the state before the newest change. */
  async undo() {
    const state = this.history.pop();
    if (state === undefined) return;
    this.sides = JSON.parse(state);
    this.state = state;
    this.changedAt = -Infinity;
    await this.choose(this.side);
    if (this.history.length === 0) byId("editor-title").focus(); // the button is disabled
  }

  /**
   * @param {EventKind} kind
   * @returns {Row[]}
   */
  kindRows(kind) {
    /** @type {Row[]} */
    const rows = [];
    /** @type {(owner: Record<string, any>, path?: string, mode?: string) => void} */
    const add = (owner, path = "", mode = "") => {
      for (const key of Object.keys(owner)) {
        const row = this.table.get(`kinds.NAME.${path}${key}`);
        if (row && owner[key] !== null) rows.push([{ ...row, doc: mode + row.doc }, owner, key]);
      }
    };
    add(kind);
    kind.modes.forEach((mode, i) => add(mode, "modes.", `Mode ${i + 1}. `));
    return rows;
  }

  /**
   * Return a section whose rows are created when it opens; `drawings` adds a curve to draw.
   * @param {string} name
   * @param {Row[]} rows
   * @param {Set<string>} open
   * @param {[{ points: number[] }, Drawing] | undefined} drawings
   */
  section(name, rows, open, drawings) {
    const details = made("details", { id: `section ${name}` }, made("summary", {}, name));
    const fill = () => {
      if (!details.open || details.children.length > 1) return;
      // the shape as it is comes first
      if (drawings) details.append(drawingOf(...drawings, () => this.changed()));
      details.append(
        ...rows.map(([parameter, owner, key]) =>
          rowOf(parameter, owner, key, () => this.changed()),
        ),
      );
    };
    details.addEventListener("toggle", fill);
    details.open = open.has(details.id);
    fill();
    return details;
  }

  // --- applying changes --------------------------------------------------------------------------

  /** Apply the newest state; states that change while a request runs are merged into one. */
  async changed() {
    this.offer(false);
    this.keepState();
    if (this.busy) {
      this.changedAgain = true;
      return;
    }
    this.busy = true;
    do {
      this.changedAgain = false;
      const { sides, playing } = this;
      if (sides === null || playing === null) break; // closed meanwhile
      const after = structuredClone(sides[this.side]);
      // positions must not move while the disk is touched
      if (this.input.active !== null) after.values[ANGLE_MAP] = playing.values[ANGLE_MAP];
      const surface = this.differs(playing, after);
      if (surface === null) continue;
      if (await this.tryTo(() => this.applyChange(playing, after, surface))) this.playing = after;
    } while (this.changedAgain);
    this.busy = false;
  }

  /** Apply the angle map that was chosen while the disk was touched. */
  applyHeldMap() {
    if (this.sides && this.playing?.values[ANGLE_MAP] !== this.preset.values[ANGLE_MAP]) this.changed();
  }

  /**
   * Return whether the surfaces of two presets differ; null if the presets are equal.
   * @param {Preset} before
   * @param {Preset} after
   */
  differs(before, after) {
    const ids = Object.keys(after.values).filter((id) => before.values[id] !== after.values[id]);
    if (!isSame([before.kinds, before.points], [after.kinds, after.points])) return true;
    if (ids.some((id) => this.table.get(id)?.surface)) return true;
    return ids.length > 0 || before.name !== after.name ? false : null;
  }

  // --- files ------------------------------------------------------------------------------------

  async toml() {
    return (await post("preset/toml", this.preset)).text();
  }

  get name() {
    return byId("editor-name").value.trim();
  }

  async download() {
    const file = new Blob([await this.toml()], { type: "application/toml" });
    const link = made("a", { href: URL.createObjectURL(file), download: `${this.name || this.preset.name}.toml` });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1e4);
  }

  async save() {
    if (this.saving) return; // a second click
    if (!NAME.test(this.name)) {
      throw new Error(`name is ${this.name || "empty"}; must be letters, digits, - and _`);
    }
    this.saving = true;
    try {
      await this.upload(await this.toml());
    } finally {
      this.saving = false;
    }
  }

  /** @param {string} body */
  async upload(body) {
    const path = `preset/${encodeURIComponent(this.name)}${this.replaces ? "?replace=1" : ""}`;
    try {
      await request(path, { method: "PUT", body });
    } catch (error) {
      const exists = error.message.includes(EXISTS);
      this.offer(exists);
      if (!exists) throw error;
      throw new Error(`preset ${this.name} already exists: replace it, or enter another name`);
    }
    this.offer(false);
    this.showMessage(`saved as ${this.name}`);
  }

  /**
   * Show whether saving replaces an existing file.
   * @param {boolean} replaces
   */
  offer(replaces) {
    this.replaces = replaces;
    byId("editor-save").textContent = replaces ? "Replace it" : "Save";
  }

  /** @param {string} text */
  showMessage(text) {
    byId("editor-message").textContent = text;
  }

  /**
   * Run an action, show its error, and return whether it succeeded.
   * @param {() => unknown} act
   */
  async tryTo(act) {
    this.showMessage("");
    try {
      await act();
      return true;
    } catch (error) {
      this.showMessage(error.message);
      return false;
    }
  }
}
