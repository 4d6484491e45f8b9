// Playback of the sound files of examples: left clicks, right vibration.

const SILENT = "The browser plays no sound. Press the button again, or check its settings.";
const START_MS = 3000;

export class ExamplePlayer {
  /** `file(path)` fetches a file. Audio starts when a click or key handler calls `start`. */
  constructor(file) {
    this.file = file;
    const { audioSession } = /** @type {any} */ (navigator);
    if (audioSession) audioSession.type = "playback"; // iPhones: audible despite the silent switch
    this.context = new AudioContext({ latencyHint: "interactive" });
    this.sounds = new Map(); // promises by path
  }

  /** Start audio; throws an Error with one line on failure. */
  async start() {
    if (this.context.state === "running") return;
    const silent = new Promise((_, reject) => {
      setTimeout(() => reject(new Error(SILENT)), START_MS);
    });
    await Promise.race([this.context.resume(), silent]);
  }

  /** Load a sound; repeated calls return the same promise, unless it failed. */
  load(path) {
    if (!this.sounds.has(path)) {
      const loaded = this.file(path).then(async (answer) =>
        this.context.decodeAudioData(await answer.arrayBuffer()));
      loaded.catch(() => this.sounds.delete(path));
      this.sounds.set(path, loaded);
    }
    return this.sounds.get(path);
  }

  /** Play a sound to its end. */
  async play(path) {
    const source = this.context.createBufferSource();
    source.buffer = await this.load(path);
    source.connect(this.context.destination);
    const ended = new Promise((resolve) => {
      source.onended = resolve;
    });
    source.start();
    await ended;
  }
}
