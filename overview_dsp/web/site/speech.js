// Speech output. Only the latest text is spoken: a sentence may last longer than a sweep.

const SETTLE_MS = 180;

export class Speech {
  constructor() {
    this.on = false;
    this.timer = 0;
  }

  /** @param {string} text */
  speak(text) {
    if (!this.on || !("speechSynthesis" in window)) return;
    clearTimeout(this.timer);
    this.timer = setTimeout(() => {
      speechSynthesis.cancel();
      speechSynthesis.speak(new SpeechSynthesisUtterance(text));
    }, SETTLE_MS);
  }

  stop() {
    clearTimeout(this.timer);
    window.speechSynthesis?.cancel();
  }
}
