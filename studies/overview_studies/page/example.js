// Example of a training: named stimuli, played in order on request.

import { retryUntilDone, make, pause } from "./make.js";

const GAP_MS = 250;

/** Show an example until Next is pressed, which waits for the end of the first playback. */
export async function showExample(kit, display, { text, captions, stimuli, output }, onLoad) {
  const { felt, study, fault, say } = kit;
  const heading = make("h1", { text, tabindex: -1 });
  const playing = make("p", { class: "lamp", text: "\u00a0" });
  const play = make("button", { type: "button", class: "play", text: "Play" });
  const next = make("button", { type: "button", class: "done", text: "Next", disabled: true });
  await retryUntilDone(() => felt.load({ stimuli, output }), display, fault);
  display.replaceChildren(heading, play, playing, next);
  heading.focus();
  window.scrollTo(0, 0);
  onLoad();
  let isPlaying = false;
  const playAll = async () => {
    await felt.start();
    for (const [i, key] of stimuli.entries()) {
      playing.textContent = captions[i];
      if (stimuli.length > 1) say(captions[i]);
      const presentation = await felt.open(key, output);
      presentation.onfault = fault;
      await presentation.rested(study.stimuli[key].duration_s);
      presentation.stop();
      await pause(GAP_MS);
    }
    next.disabled = false;
  };
  play.addEventListener("click", async () => {
    if (isPlaying) return;
    isPlaying = true;
    play.setAttribute("aria-disabled", "true");
    try {
      await playAll();
    } catch (error) {
      fault(error.message);
    }
    playing.textContent = "\u00a0";
    play.removeAttribute("aria-disabled");
    isPlaying = false;
  });
  await new Promise((resolve) => {
    next.addEventListener("click", () => {
      if (!isPlaying) resolve(undefined);
    });
  });
  return null;
}
