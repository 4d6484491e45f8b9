// The served preset's file: saved on the desk, felt here. The browser connects again by itself.

/** @import { Preset } from "../types" */
/** @import { Page } from "./page.js" */

/** @param {Preset | null} preset */
const known = (preset) => JSON.stringify(preset);

export class PresetLink {
  /** @param {Page} page */
  constructor(page) {
    this.page = page;
    /** @type {Preset | null} */
    this.sounding = null; // the preset of the files, as it was told last
    this.source = new EventSource(new URL("preset/changes", import.meta.url));
    this.source.onmessage = ({ data }) => this.take(JSON.parse(data));
    this.gone = false;
    this.source.onerror = () => this.lost();
    this.source.onopen = () => this.found();
    this.source.addEventListener("refused", ({ data }) => page.fault(JSON.parse(data)));
  }

  /** The server is gone, said once; the browser looks for it again by itself. */
  lost() {
    if (this.gone) return;
    this.gone = true;
    this.page.fault(this.source.readyState === EventSource.CLOSED
      ? "the server lets this page in no more: open the address printed last"
      : "the server is gone: what is here goes on, and the rest when it is back");
  }

  found() {
    if (this.gone) this.page.fault("");
    this.gone = false;
  }

  /** @param {Preset} after */
  async take(after) {
    const before = this.sounding;
    this.sounding = after;
    if (before === null || known(before) === known(after)) return;
    const { page } = this;
    try {
      if (page.atHost) {
        page.data.preset = after;
        page.shown.drawAgain();
      }
      if (page.bench.open) {
        await page.bench.take(after, page.atHost);
      } else {
        if (!page.atHost) await page.feel(page.data.preset ?? before, after, true);
        page.bench.forget();
      }
      page.fault("");
    } catch (error) {
      page.fault(error.message);
    }
  }
}
