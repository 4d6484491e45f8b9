// The page of a study: who takes part, what is still to be done, and the end.

import { Answers } from "./answers.js";
import { Server } from "./client.js";
import { byId } from "./dom.js";
import { endSession } from "./ending.js";
import { Felt } from "./felt.js";
import { goThrough } from "./flow.js";
import { openKept } from "./kept.js";
import { insisted, make } from "./make.js";
import { keepOffline } from "./offline.js";
import { openSession, Sessions } from "./opening.js";
import { NOBODY } from "./pad.js";
import { progressOf } from "./plan.js";
import { Twist } from "./twist.js";

const PATIENCE_MS = 2000;

const fault = (line) => {
  byId("fault").textContent = line;
};

const say = (line) => {
  byId("said").textContent = line;
};

/** A server or host, entered by the token of the address, which is taken out of it and kept. */
async function entered(kept) {
  const token = new URLSearchParams(location.hash.slice(1)).get("token");
  if (!token) return new Server((await kept.get("token")) ?? null);
  const server = new Server(token);
  await server.enter();
  await kept.put("token", token);
  history.replaceState(null, "", location.pathname + location.search);
  return server;
}

/** Whether no other tab has this session; held until the page is closed. */
function isAlone(session) {
  // without a secure context there are no locks: the server keeps the first answer to each trial
  if (!navigator.locks) return Promise.resolve(true);
  return new Promise((resolve) => {
    const signal = AbortSignal.timeout(PATIENCE_MS); // a page that is just being left still has it
    navigator.locks.request(`overview-study ${session}`, { signal }, () => {
      resolve(true);
      return new Promise(() => {});
    }).catch(() => resolve(false));
  });
}

/** What trials and screens share. */
function kitOf({ study, list, felt, answers, leave, file }) {
  const trials = list.steps.filter(({ stimuli }) => stimuli);
  return {
    study, felt, answers, leave, file, say, fault,
    twist: new Twist(NOBODY),
    progress() {
      const { done, total } = progressOf(list.steps, answers.done);
      byId("progress").max = total;
      byId("progress").value = done;
      byId("count").textContent = `${done} of ${total}`;
      byId("progress-line").hidden = false;
    },
    ahead({ id }) {
      const next = trials[trials.findIndex((one) => id.startsWith(one.id)) + 1];
      // where it fails, the trial itself will tell
      if (next) felt.load(next).catch(() => {});
    },
  };
}

async function main() {
  // browsers give sound, a store for pages and locks to no other
  if (!window.isSecureContext) throw new Error("it needs https, or a server on this very machine");
  const kept = await openKept();
  const server = await entered(kept);
  const file = (path) => server.file(path);
  const study = await (await file("study.json")).json();
  server.sessions = study.server?.sessions ?? "";
  document.title = study.title;
  if (study.server === null) {
    keepOffline();
    navigator.serviceWorker?.ready.then(({ active }) => active?.postMessage("keep windows"));
  }
  const sessions = new Sessions(kept, study);
  const felt = new Felt(study, file);
  const display = byId("study");
  const context = {
    study, display, sessions, felt, fault, say, server: study.server === null ? null : server,
  };
  const { answers: stored, ...session } = await openSession(context);
  byId("title").textContent = study.title;
  if (!(await isAlone(session.session))) {
    display.replaceChildren(make("h1", { text: "This session is open in another tab" }),
      make("p", { text: "Go on there, or close it and load this page again." }));
    return;
  }
  const name = `lists/${String(session.list).padStart(3, "0")}.json`;
  const list = await insisted(async () => (await file(name)).json(), display, fault);
  const send = context.server && ((id, row) => server.store(session, id, row));
  const answers = new Answers(kept, session.session, send, {
    onchange: () => tellWaiting(answers),
    onrefused: (line) => fault(`An answer isn't taken: ${line}. Please tell the experimenter.`),
  });
  await answers.open(stored);
  addEventListener("online", () => answers.hurry());
  addEventListener("beforeunload", (event) => {
    if (answers.unsent.size > 0) event.preventDefault();
  });
  const leave = async () => {
    await sessions.kept.remove(sessions.present);
    display.replaceChildren(make("h1", { text: "Thank you" }),
      make("p", { text: "You did not agree, so nothing was kept. You may close this page." }));
  };
  const kit = kitOf({ study, list, felt, answers, leave, file });
  await goThrough(context, session, list, kit);
  kit.twist.end();
  byId("progress-line").hidden = true;
  await endSession(context, session, answers);
}

function tellWaiting({ unsent }) {
  const { size } = unsent;
  byId("waiting").textContent = size > 1 ? `${size} answers wait to be stored` : "";
}

addEventListener("unhandledrejection", ({ reason }) => fault(reason?.message ?? String(reason)));
main().catch((error) => fault(`The study can't go on: ${error.message}`));
