// Start of a session: resumes the session of this browser or starts a new one.

import { csvOf } from "./csv.js";
import { button, retryUntilDone, make, paragraphs } from "./make.js";
import { Answers } from "./answers.js";

const CODE = "[A-Za-z0-9_\\-]{1,32}";

/** Sessions of a study in this browser. */
export class Sessions {
  constructor(store, { design_sha256: design }) {
    this.store = store;
    this.present = `session ${design}`;
    this.past = `past ${design} `;
  }

  /** Return the session in progress, or undefined. */
  get() {
    return this.store.get(this.present);
  }

  put(session) {
    return this.store.put(this.present, session);
  }

  /** Mark a session as ended; it stays available for the CSV. */
  async end(session) {
    await this.store.put(this.past + session.session, session);
    await this.store.remove(this.present);
  }

  /** Return the ended sessions. */
  async ended() {
    return (await this.store.entries(this.past)).map(([, session]) => session);
  }

  /** Return the answers of sessions as CSV. */
  async csv(sessions) {
    const rows = await Promise.all(sessions.map(({ session }) =>
      new Answers(this.store, session, null).rows()));
    return csvOf(sessions.map((session, i) => [session, rows[i]]));
  }
}

/** Download a text file. */
export function download(name, text) {
  const url = URL.createObjectURL(new Blob([text], { type: "text/csv" }));
  make("a", { href: url, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(url), 60_000);
}

/**
 * Resolves when the participant has started or resumed: session, list, participant, and `answers` of
 * the server. `server` is null in a folder.
 */
export async function openSession(context) {
  const { sessions } = context;
  const found = await sessions.get();
  if (found?.session && (await confirmResume(context, found))) {
    if (context.server === null) return found;
    const resumedSession = await retryUntilDone(() => resumed(context, found), context.display, context.fault);
    if (resumedSession !== null) return { ...found, ...resumedSession };
  }
  return startNew(context, found?.session ? undefined : found);
}

/** Return the session from the server; null with a message if the server does not know it. */
async function resumed({ server, fault }, found) {
  try {
    return await server.resume(found);
  } catch (error) {
    if (error.status !== 403) throw error;
    fault(`Session ${found.session} cannot continue: ${error.message}.`);
    return null;
  }
}

/** Ask whether the same participant continues. */
function confirmResume({ study, display, sessions, felt, fault }, found) {
  return new Promise((resolve) => {
    const heading = make("h1", { text: "Welcome back", tabindex: -1 });
    const go = button("Continue", () => {
      felt.start().catch((error) => fault(error.message));
      resolve(true);
    }, { class: "done" });
    const other = button("Start as another participant", async () => {
      const line = `End the session of ${found.participant} and start a new one?`;
      if (!window.confirm(line)) return;
      const waiting = new Answers(sessions.store, found.session, null);
      if (study.server !== null && (await waiting.rows()).some(([, { sent }]) => !sent)) {
        fault("Some answers of this session are not stored yet. Continue the session first.");
        return;
      }
      await sessions.end(found);
      resolve(false);
    });
    display.replaceChildren(heading, make("p", {
      text: `You take part as ${found.participant}. The session resumes where you stopped.`,
    }), go, other);
    heading.focus();
  });
}

/** Start a new session; `requested` is a session request without a response. */
function startNew(context, requested) {
  const { study, display, fault, say, felt } = context;
  return new Promise((resolve) => {
    const heading = make("h1", { text: study.title, tabindex: -1 });
    const code = make("input", {
      id: "code", type: "text", pattern: CODE, maxlength: 32, autocomplete: "off",
      autocapitalize: "off", spellcheck: "false", value: requested?.participant ?? "",
      "aria-describedby": "code-hint",
    });
    const parts = [make("label", { for: "code", text: "Your participant code, if you have one" }), code,
      make("p", { id: "code-hint", class: "note", text: "Letters, digits, - and _. Do not enter your name." })];
    const number = study.server === null ? listInput(study) : null;
    if (number) parts.push(make("label", { for: "list", text: "List" }), number);
    let busy = false;
    const go = button("Begin", async () => {
      if (busy) return;
      const wrong = [code, number].find((field) => field && !field.checkValidity());
      if (wrong) {
        say(wrong === code ? "A code must contain only letters, digits, - and _." : `The list must be 1 to ${study.lists}.`);
        wrong.focus();
        return;
      }
      busy = true;
      felt.start().catch((error) => fault(error.message));
      try {
        resolve(await begin(context, requested, code.value, Number(number?.value)));
      } catch (error) {
        fault(error.message);
        busy = false;
      }
    }, { class: "done" });
    const form = make("form", { class: "items", on: { submit: (event) => {
      event.preventDefault();
      go.click();
    } } }, ...parts);
    display.replaceChildren(heading, ...paragraphs(study.text.welcome), form, go);
    showEndedSessions(context);
    heading.focus();
  });
}

/** Begin a session with a list of the server, or with the selected list. */
async function begin({ sessions, server, fault }, requested, participant, list) {
  fault("");
  if (server === null) {
    const made = {
      session: newId(), list, participant: participant || `p${String(list).padStart(3, "0")}`,
    };
    await sessions.put(made);
    return made;
  }
  // the request is stored first, so a repeated request gets the same list
  const request = requested?.request ?? newId();
  await sessions.put({ request, participant });
  let reply;
  try {
    reply = await server.begin(request, participant);
  } catch (error) {
    if (error.status === 409) await sessions.store.remove(sessions.present);
    throw error;
  }
  const { answers, ...session } = reply;
  await sessions.put(session);
  return { ...session, answers };
}

function listInput({ lists }) {
  const number = new URLSearchParams(location.search).get("list") ?? "1";
  return make("input", {
    id: "list", type: "number", min: 1, max: lists, step: 1, value: number, required: true,
    inputmode: "numeric",
  });
}

/** Show who has finished in this browser, and without a server offer the answers. */
async function showEndedSessions({ study, sessions, display }) {
  const ended = await sessions.ended();
  if (ended.length === 0) return;
  const { participant } = ended.at(-1);
  const line = `${participant} has finished in this browser. Other participants can start here.`;
  display.append(make("p", { class: "note", text: line }));
  if (study.server !== null) return;
  display.append(button("Download all answers of this browser (CSV)", async () => {
    download(`${study.name}.csv`, await sessions.csv(ended));
  }));
}

/** 32 hexadecimal digits. */
function newId() {
  const octets = crypto.getRandomValues(new Uint8Array(16));
  return Array.from(octets, (octet) => octet.toString(16).padStart(2, "0")).join("");
}
