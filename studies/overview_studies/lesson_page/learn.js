// Lesson: examples with their names, then questions. The server stores each step.

import { openBrowserStore } from "./browser_store.js";
import { Server } from "./client.js";
import { byId } from "./dom.js";
import { ExamplePlayer } from "./example_player.js";
import { button, make, pause, pressed, retryUntilDone } from "./make.js";

const BEFORE_MS = 500; // a screen reader begins with the heading
const BETWEEN_MS = 250;

const fault = (line) => {
  byId("fault").textContent = line;
};

const say = (line) => {
  byId("said").textContent = line;
};

/** Connect to the server; the token moves from the address to the store. */
async function connect() {
  const store = await openBrowserStore();
  const token = new URLSearchParams(location.hash.slice(1)).get("token");
  if (!token) return new Server((await store.get("lesson token")) ?? null);
  const server = new Server(token);
  await server.enter();
  await store.put("lesson token", token);
  history.replaceState(null, "", location.pathname + location.search);
  return server;
}

/** Show a screen with a heading, which gets the focus. */
function show(heading, ...parts) {
  const title = make("h1", { text: heading, tabindex: -1 });
  byId("study").replaceChildren(title, ...parts);
  title.focus();
}

function showProgress(done, total) {
  byId("progress").max = total;
  byId("progress").value = done;
  byId("count").textContent = `${done} of ${total}`;
  byId("progress-line").hidden = false;
}

/** Switch buttons on or off; they keep the focus. */
function enable(buttons, on) {
  for (const one of buttons) one.setAttribute("aria-disabled", String(!on));
}

const isEnabled = (one) => one.getAttribute("aria-disabled") !== "true";

/** The lesson on this page. */
class Lesson {
  constructor(server, content, player) {
    this.server = server;
    this.content = content;
    this.player = player;
    this.playing = make("p", { class: "lamp" });
  }

  /** Return what `act` returns; on failure show the error and a button to try again. */
  retry(act) {
    return retryUntilDone(act, byId("study"), fault);
  }

  /** Play examples in order, with the caption of each. */
  async play(examples) {
    await pause(BEFORE_MS);
    for (const { caption, sound } of examples) {
      this.playing.textContent = caption;
      if (examples.length > 1) say(caption);
      await this.retry(() => this.player.play(sound));
      await pause(BETWEEN_MS);
    }
    this.playing.textContent = "";
  }

  /** Return a button that plays examples again; `others` wait for the end. */
  againButton(examples, others) {
    const again = button("Play again", async () => {
      if (!isEnabled(again)) return;
      enable([again, ...others], false);
      await this.play(examples);
      enable([again, ...others], true);
    }, { class: "again-button" });
    return again;
  }

  /** Store that a step is complete. */
  complete(step, answer) {
    const body = answer === undefined ? { step } : { step, answer };
    return this.retry(() => this.server.json("POST", "lesson/steps", body));
  }

  /** Present the examples of a step until Next is pressed. */
  async present(index, { text, part, examples }) {
    const { headings } = this.content;
    const next = make("button", { type: "button", class: "done", text: "Next" });
    const again = this.againButton(examples, [next]);
    const left = new Promise((resolve) => {
      next.addEventListener("click", () => {
        if (isEnabled(next)) resolve(undefined);
      });
    });
    enable([next, again], false);
    show(text, make("p", { class: "note", text: headings[part] }), this.playing, next, again);
    await this.play(examples);
    enable([next, again], true);
    await left;
    await this.complete(index);
  }

  /** Ask a question; the first answer counts. */
  async ask(index, { text, examples }) {
    const { choices, headings, references } = this.content;
    const answered = make("div", { class: "choices", role: "group", "aria-label": "Answers" });
    const again = this.againButton(examples, []);
    let choose = /** @type {(kind: string) => void} */ (() => {});
    const chosen = new Promise((resolve) => {
      choose = resolve;
    });
    const buttons = choices.map(({ kind, label }, i) => {
      const one = make("button", { type: "button", class: "choice" }, make("small", { text: String(i + 1) }), label);
      one.addEventListener("click", () => {
        if (isEnabled(one)) choose(kind);
      });
      return one;
    });
    answered.append(...buttons);
    const byKey = ({ key, repeat }) => {
      if (!repeat) buttons[Number(key) - 1]?.click();
    };
    enable([...buttons, again], false);
    show(text, make("p", { class: "note", text: headings.question }), this.playing, answered, again);
    this.playing.textContent = "";
    await this.play(examples.map((one) => ({ ...one, caption: "" })));
    enable([...buttons, again], true);
    document.addEventListener("keydown", byKey);
    const answer = await chosen;
    document.removeEventListener("keydown", byKey);
    enable([...buttons, again], false);
    const { right, was } = await this.complete(index, answer);
    const labelOf = (kind) => choices.find((one) => one.kind === kind).label;
    const line = right ? `Right: ${labelOf(was)}.` : `It was ${labelOf(was)}, not ${labelOf(answer)}.`;
    const box = make("p", { class: "feedback", "data-right": String(right), text: line });
    again.remove();
    byId("study").append(box);
    say(line);
    if (!right) await this.play([{ caption: labelOf(was), sound: references[was] }]);
    const next = pressed("Next", { class: "done" }, byId("study"));
    /** @type {HTMLElement} */ (byId("study").lastElementChild).focus();
    await next;
  }

  /** Run the remaining steps. */
  async run() {
    const { steps } = this.content;
    for (let i = this.content.done; i < steps.length; i += 1) {
      showProgress(i, steps.length);
      steps[i + 1]?.examples.forEach(({ sound }) => this.player.load(sound).catch(() => {}));
      if (steps[i].part === "question") await this.ask(i, steps[i]);
      else await this.present(i, steps[i]);
    }
    byId("progress-line").hidden = true;
  }
}

/** Show the score, and wait until another pass is wanted; resolves to the body of its request. */
function wanted({ score, scores }) {
  return new Promise((resolve) => {
    const days = scores.map(({ date, right, of }) => make("li", { text: `${date}: ${right} of ${of}` }));
    show("Your score", make("p", { text: score }),
      make("p", { text: "The score is stored. Another day has other questions." }),
      make("ul", { class: "scores", "aria-label": "All scores" }, ...days),
      button("Ask ten questions", () => resolve({ again: false }), { class: "done" }),
      button("Repeat the whole lesson", () => resolve({ again: true })));
    say(score);
  });
}

async function main() {
  const server = await connect();
  const player = new ExamplePlayer((path) => server.file(path));
  let content = await server.json("GET", "lesson");
  document.title = `Lesson: ${content.title}`;
  byId("title").textContent = content.title;
  for (;;) {
    if (content.score === null) {
      show("Learn what it feels like", make("p", { text: content.welcome }),
        make("p", { text: "Use headphones or an actuator. Clicks sound left, the vibration right." }));
      const begin = content.done > 0 ? "Continue" : "Begin";
      await pressed(begin, { class: "done" }, byId("study"));
      await retryUntilDone(() => player.start(), byId("study"), fault);
      await new Lesson(server, content, player).run();
      content = await retryUntilDone(() => server.json("GET", "lesson"), byId("study"), fault);
    }
    const body = await wanted(content);
    content = await retryUntilDone(() => server.json("POST", "lesson/passes", body), byId("study"), fault);
  }
}

addEventListener("unhandledrejection", ({ reason }) => fault(reason?.message ?? String(reason)));
main().catch((error) => fault(`The lesson cannot continue: ${error.message}`));
