// The served preset: the page applies each change of its file. The browser reconnects by itself.

/** @import { Preset, ServedParts } from "../types" */
/** @import { PresetEditor } from "./preset_editor.js" */

/** @param {Preset | null} preset */
const keyOf = (preset) => JSON.stringify(preset);

export class PresetLink {
  /**
   * @param {ServedParts} parts
   * @param {PresetEditor} editor
   */
  constructor(parts, editor) {
    this.parts = parts;
    this.editor = editor;
    /** @type {Preset | null} */
    this.preset = null; // the last preset that the server sent
    this.source = new EventSource(new URL("preset/changes", import.meta.url));
    this.source.onmessage = ({ data }) => this.onPreset(JSON.parse(data));
    /** @type {number | null} */
    this.lostState = null; // what was reported, a `readyState`; null: connected
    this.source.onerror = () => this.onLost();
    this.source.onopen = () => this.onReconnect();
    this.source.addEventListener("refused", ({ data }) => parts.actions.fault(JSON.parse(data)));
  }

  /** Report each state once in which the server can't be reached. */
  onLost() {
    if (this.lostState === this.source.readyState) return;
    this.lostState = this.source.readyState;
    this.parts.actions.fault(this.lostState === EventSource.CLOSED
      ? "the server no longer accepts this page: open the URL printed last"
      : "the server can't be reached: this page keeps working and reconnects");
  }

  onReconnect() {
    if (this.lostState !== null) this.parts.actions.fault("");
    this.lostState = null;
  }

  /** @param {Preset} after */
  async onPreset(after) {
    const before = this.preset;
    this.preset = after;
    if (before === null || keyOf(before) === keyOf(after)) return;
    const { editor } = this;
    const { actions, atHost, changePreset, data, viewState } = this.parts;
    try {
      if (atHost) {
        data.preset = after;
        viewState.drawAgain();
      }
      if (editor.open) {
        await editor.addSavedPreset(after, atHost);
      } else {
        if (!atHost) await changePreset(data.preset ?? before, after, true);
        editor.reset();
      }
      actions.fault("");
    } catch (error) {
      actions.fault(error.message);
    }
  }
}
