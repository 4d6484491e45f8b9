// Main script of a study's page: start, steps and end of a session.

import { Answers } from "./answers.js";
import { Server } from "./client.js";
import { byId } from "./dom.js";
import { endSession } from "./session_end.js";
import { StimulusPlayer } from "./stimulus_player.js";
import { runSteps } from "./flow.js";
import { openBrowserStore } from "./browser_store.js";
import { retryUntilDone, make } from "./make.js";
import { keepOffline } from "./offline.js";
import { openSession, Sessions } from "./session_start.js";
import { NO_INPUT } from "./pad.js";
import { progressOf } from "./plan.js";
import { Twist } from "./twist.js";

const LOCK_TIMEOUT_MS = 2000;

const fault = (line) => {
  byId("fault").textContent = line;
};

const say = (line) => {
  byId("said").textContent = line;
};

/** Connect to a server or host; the token moves from the address to the store. */
async function connect(store) {
  const token = new URLSearchParams(location.hash.slice(1)).get("token");
  if (!token) return new Server((await store.get("token")) ?? null);
  const server = new Server(token);
  await server.enter();
  await store.put("token", token);
  history.replaceState(null, "", location.pathname + location.search);
  return server;
}

/** Lock the session for this tab; resolves to false if another tab has it. */
function acquireLock(session) {
  // without locks, the server still accepts only the first answer of each trial
  if (!navigator.locks) return Promise.resolve(true);
  return new Promise((resolve) => {
    const signal = AbortSignal.timeout(LOCK_TIMEOUT_MS); // a page that is closing may still hold it
    navigator.locks.request(`overview-study ${session}`, { signal }, () => {
      resolve(true);
      return new Promise(() => {});
    }).catch(() => resolve(false));
  });
}

/** Return the objects that trials and screens share. */
function kitOf({ study, list, felt, answers, leave, file }) {
  const trials = list.steps.filter(({ stimuli }) => stimuli);
  return {
    study, felt, answers, leave, file, say, fault,
    twist: new Twist(NO_INPUT),
    progress() {
      const { done, total } = progressOf(list.steps, answers.done);
      byId("progress").max = total;
      byId("progress").value = done;
      byId("count").textContent = `${done} of ${total}`;
      byId("progress-line").hidden = false;
    },
    preload({ id }) {
      const next = trials[trials.findIndex((one) => id.startsWith(one.id)) + 1];
      // errors are shown when the trial loads
      if (next) felt.load(next).catch(() => {});
    },
  };
}

async function main() {
  // AudioWorklet, storage and locks require a secure context
  if (!window.isSecureContext) throw new Error("the page requires https or a server on this computer");
  const store = await openBrowserStore();
  const server = await connect(store);
  const file = (path) => server.file(path);
  const study = await (await file("study.json")).json();
  server.sessions = study.server?.sessions ?? "";
  document.title = study.title;
  if (study.server === null) {
    keepOffline();
    navigator.serviceWorker?.ready.then(({ active }) => active?.postMessage("keep windows"));
  }
  const sessions = new Sessions(store, study);
  const felt = new StimulusPlayer(study, file);
  const display = byId("study");
  const context = {
    study, display, sessions, felt, fault, say, server: study.server === null ? null : server,
  };
  const { answers: stored, ...session } = await openSession(context);
  byId("title").textContent = study.title;
  if (!(await acquireLock(session.session))) {
    display.replaceChildren(make("h1", { text: "This session is open in another tab" }),
      make("p", { text: "Continue in that tab, or close it and reload this page." }));
    return;
  }
  const name = `lists/${String(session.list).padStart(3, "0")}.json`;
  const list = await retryUntilDone(async () => (await file(name)).json(), display, fault);
  const send = context.server && ((id, row) => server.store(session, id, row));
  const answers = new Answers(store, session.session, send, {
    onchange: () => showUnsent(answers),
    onrefused: (line) => fault(`The server rejected an answer: ${line}. Please inform the experimenter.`),
  });
  await answers.open(stored);
  addEventListener("online", () => answers.retryNow());
  addEventListener("beforeunload", (event) => {
    if (answers.unsent.size > 0) event.preventDefault();
  });
  const leave = async () => {
    await sessions.store.remove(sessions.present);
    display.replaceChildren(make("h1", { text: "Thank you" }),
      make("p", { text: "You did not agree, so nothing was stored. You may close this page." }));
  };
  const kit = kitOf({ study, list, felt, answers, leave, file });
  await runSteps(context, session, list, kit);
  kit.twist.end();
  byId("progress-line").hidden = true;
  await endSession(context, session, answers);
}

function showUnsent({ unsent }) {
  const { size } = unsent;
  byId("waiting").textContent = size > 1 ? `${size} answers are not stored yet` : "";
}

addEventListener("unhandledrejection", ({ reason }) => fault(reason?.message ?? String(reason)));
main().catch((error) => fault(`The study cannot continue: ${error.message}`));
